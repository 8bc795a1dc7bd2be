/** The last second of a wire, drawn: a lane for each that speaks, collisions across all. */

import { useEffect, useRef, useState } from "preact/hooks";
import { onFrames, Sight } from "../../parts/frames";
import { palette } from "../../parts/palette";
import { theme } from "../../theme";
import { timeLine, type TimeLine } from "./time_line";
import type { WireFeed } from "./wire_feed";

const LANE_PX = 18;
const LABEL_PX = 96;
const FOOT_PX = 18;
const TICKS = 5;
/** Least width of a tick with its label. */
const TICK_PX = 64;
const LEAST_PX = 1.5;
/** Width by which a collision is drawn beyond its begin and end. */
const COLLISION_PX = 4;

export function TimeLinePane({ feed, isPaused }: { feed: WireFeed; isPaused: boolean }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [lanes, setLanes] = useState(feed.lanes.length);
  const [said, setSaid] = useState("");
  useEffect(() => {
    const element = canvas.current!;
    const sight = new Sight(element);
    let drawn = "";
    const paused_s = isPaused ? feed.now_s() : undefined;
    const end = onFrames({
      isDue: () => sight.isIn,
      draw: () => {
        const now_s = paused_s ?? feed.now_s();
        const line = timeLine(feed.log.since(now_s - 1), now_s, feed.lanes);
        const state = `${line.bars.length} ${feed.news.peek()} ${element.clientWidth} ${theme.peek()}`;
        const isStill = paused_s !== undefined || !line.bars.length;
        if (isStill && state === drawn) return;
        drawn = state;
        if (line.lanes.length !== feed.lanes.length) {
          feed.lanes = line.lanes;
          setLanes(line.lanes.length);
        }
        draw(element, line);
      },
    });
    return () => {
      end();
      sight.end();
    };
  }, [feed, isPaused]);
  useEffect(() => {
    const timer = window.setInterval(() => {
      const now_s = feed.now_s();
      const { bars, collisions } = timeLine(feed.log.since(now_s - 1), now_s, feed.lanes);
      setSaid(`${new Set(bars.map(({ packet }) => packet)).size} packets, ${collisions.length} collisions in the last second`);
    }, 2000);
    return () => window.clearInterval(timer);
  }, [feed]);
  return (
    <canvas
      ref={canvas}
      class="time-line"
      role="img"
      aria-label={`Time line of the last second: ${said}`}
      style={{ height: Math.max(lanes, 1) * LANE_PX + FOOT_PX }}
    />
  );
}

function draw(canvas: HTMLCanvasElement, line: TimeLine): void {
  const colours = palette();
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  if (!context) return;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = `12px ${colours.mono}`;
  const label = Math.min(LABEL_PX, width / 3);
  const span = width - label;
  const bottom = line.lanes.length * LANE_PX;
  drawScale(context, label, span, bottom, colours);
  context.textAlign = "left";
  line.lanes.forEach((name, lane) => {
    context.fillStyle = colours.soft;
    context.fillText(fitted(context, name, label - 6), 0, lane * LANE_PX + 13);
    context.fillStyle = colours.grid;
    context.fillRect(label, (lane + 1) * LANE_PX - 1, span, 1);
  });
  drawCollisions(context, line, label, span, bottom, colours);
  for (const { packet, lane, begin, end } of line.bars) {
    context.fillStyle = packet.error === null ? colours.traces[lane % colours.traces.length]! : colours.bad;
    context.fillRect(label + begin * span, lane * LANE_PX + 3, Math.max((end - begin) * span, LEAST_PX), LANE_PX - 6);
  }
}

/** Draw collisions wider than they last, across all lanes: even a short one is seen. */
function drawCollisions(
  context: CanvasRenderingContext2D,
  line: TimeLine,
  left: number,
  span: number,
  bottom: number,
  colours: ReturnType<typeof palette>,
): void {
  for (const { begin, end } of line.collisions) {
    const x = left + begin * span - COLLISION_PX;
    const width = (end - begin) * span + 2 * COLLISION_PX;
    context.fillStyle = colours.badBand;
    context.fillRect(x, 0, width, bottom);
    context.strokeStyle = colours.bad;
    context.strokeRect(Math.round(x) + 0.5, 0.5, Math.round(width), bottom - 1);
  }
}

function drawScale(context: CanvasRenderingContext2D, left: number, span: number, bottom: number, colours: ReturnType<typeof palette>): void {
  const step = span / TICKS < TICK_PX ? TICKS : 1;
  for (let tick = 0; tick <= TICKS; tick += step) {
    const x = left + (tick / TICKS) * span;
    context.fillStyle = colours.grid;
    context.fillRect(Math.min(x, left + span - 1), 0, 1, bottom);
    context.fillStyle = colours.soft;
    context.textAlign = tick === 0 ? "left" : tick === TICKS ? "right" : "center";
    context.fillText(tick === TICKS ? "now" : `−${(1 - tick / TICKS).toFixed(1)} s`, x, bottom + 14);
  }
}

function fitted(context: CanvasRenderingContext2D, text: string, width: number): string {
  if (context.measureText(text).width <= width) return text;
  let cut = text;
  while (cut && context.measureText(`${cut}…`).width > width) cut = cut.slice(0, -1);
  return `${cut}…`;
}
