/** The time line of a wire, drawn: a lane for each that speaks, collisions across all. It zooms, and goes back as far as the
 * log does. */

import { useEffect, useRef, useState } from "preact/hooks";
import { onFrames, Sight } from "../../parts/frames";
import { palette } from "../../parts/palette";
import { theme } from "../../theme";
import { timeText } from "./columns";
import type { WirePacket } from "./packet_log";
import { marksOf, moved, SPAN_S, timeLine, type TimeLine, zoomed } from "./time_line";
import type { WireFeed } from "./wire_feed";

const LANE_PX = 18;
const LABEL_PX = 112;
const FOOT_PX = 18;
/** Least width of a tick with its label. */
const TICK_PX = 90;
const LEAST_PX = 1;
const WHEEL_TIMES = 1.25;
/** Part of the span that a key or a button moves by. */
const PAGE = 0.25;
/** Distance from which on a press is a drag. */
const DRAG_PX = 4;
/** A span of a second is drawn each frame, longer ones as seldom as their picture changes. */
const REDRAW_MS_PER_S = 20;

interface Props {
  feed: WireFeed;
  isPaused: boolean;
  chosen: number | undefined;
  choose(packet: WirePacket): void;
}

export function TimeLinePane({ feed, isPaused, chosen, choose }: Props) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [lanes, setLanes] = useState(feed.lanes.length);
  const [said, setSaid] = useState("");
  useDrawing(canvas, feed, chosen, setLanes);
  useEffect(() => {
    const tell = () => {
      const { bars, collisions } = lineOf(feed).line;
      setSaid(`${new Set(bars.map(({ packet }) => packet)).size} packets, ${collisions.length} collisions`);
    };
    tell();
    const timer = window.setInterval(tell, 2000);
    return () => window.clearInterval(timer);
  }, [feed, isPaused]);
  const { span_s, end_s } = feed.window.value;
  return (
    <>
      <Tools feed={feed} />
      <canvas
        ref={canvas}
        class="time-line"
        role="img"
        tabIndex={0}
        aria-label={`Time line of ${timeText(span_s)} ${end_s === null ? "up to now" : `up to ${end_s.toFixed(6)} s`}: ${said}. Arrow keys go back and on, + and − zoom, End is now.`}
        style={{ height: `${Math.max(lanes, 1) * LANE_PX + FOOT_PX}px` }}
        onKeyDown={(event) => onKey(event, feed)}
        {...pointing(feed, choose)}
      />
    </>
  );
}

function lineOf(feed: WireFeed): { line: TimeLine; to_s: number; now_s: number } {
  const { span_s, end_s } = feed.window.peek();
  const source = feed.source;
  const now_s = source.now_s ?? feed.now_s();
  const to_s = end_s ?? now_s;
  return { line: timeLine(source.log.between(to_s - span_s, to_s), to_s, feed.lanes, span_s), to_s, now_s };
}

/** Draw what changes, no oftener than it is seen. */
function useDrawing(canvas: { current: HTMLCanvasElement | null }, feed: WireFeed, chosen: number | undefined, setLanes: (count: number) => void): void {
  useEffect(() => {
    const element = canvas.current!;
    element.addEventListener("wheel", onWheel, { passive: false });
    const sight = new Sight(element);
    let drawn = "";
    let next_ms = 0;
    const end = onFrames({
      isDue: () => sight.isIn && performance.now() >= next_ms,
      draw: () => {
        const window = feed.window.peek();
        next_ms = performance.now() + window.span_s * REDRAW_MS_PER_S;
        const isStill = window.end_s !== null || feed.paused.peek() !== undefined;
        const state = `${window.span_s} ${window.end_s} ${feed.paused.peek() !== undefined} ${feed.news.peek()} ${element.clientWidth} ${theme.peek()}`;
        if (isStill && state === drawn) return;
        drawn = state;
        const { line, to_s, now_s } = lineOf(feed);
        if (line.lanes.length !== feed.lanes.length) {
          feed.lanes = line.lanes;
          setLanes(line.lanes.length);
          drawn = "";
        }
        draw(element, line, to_s, window.span_s, window.end_s === null ? now_s : null, chosen);
      },
    });
    const forget = feed.window.subscribe(() => (next_ms = 0));
    function onWheel(event: WheelEvent): void {
      if (!event.ctrlKey && !event.shiftKey) return; // the page scrolls
      event.preventDefault();
      const at = placeIn(element, event.clientX);
      const by = event.deltaY || event.deltaX;
      if (event.ctrlKey) feed.window.value = zoomed(feed.window.peek(), by > 0 ? WHEEL_TIMES : 1 / WHEEL_TIMES, at);
      else move(feed, by > 0 ? PAGE : -PAGE);
    }
    return () => {
      end();
      forget();
      sight.end();
      element.removeEventListener("wheel", onWheel);
    };
  }, [feed, chosen]);
}

function move(feed: WireFeed, parts: number): void {
  const source = feed.source;
  const now_s = source.now_s ?? feed.now_s();
  feed.window.value = moved(feed.window.peek(), parts, now_s, source.log.at(0)?.at_s ?? now_s);
}

function onKey(event: KeyboardEvent, feed: WireFeed): void {
  const window = feed.window.peek();
  const page = event.shiftKey ? 1 : PAGE;
  if (event.key === "ArrowLeft") move(feed, -page);
  else if (event.key === "ArrowRight") move(feed, page);
  else if (event.key === "+" || event.key === "=") feed.window.value = zoomed(window, 0.5, 0.5);
  else if (event.key === "-") feed.window.value = zoomed(window, 2, 0.5);
  else if (event.key === "End") feed.window.value = { ...window, end_s: null };
  else if (event.key === "Home") move(feed, -1e9);
  else return;
  event.preventDefault();
}

function Tools({ feed }: { feed: WireFeed }) {
  const { span_s, end_s } = feed.window.value;
  return (
    <div class="row lane-tools" role="group" aria-label="Part of the time line">
      <h2 id="line-title">Time line</h2>
      <button type="button" aria-label="Back" onClick={() => move(feed, -PAGE * 2)}>
        ◂
      </button>
      <button type="button" aria-label="On" disabled={end_s === null} onClick={() => move(feed, PAGE * 2)}>
        ▸
      </button>
      <button type="button" aria-label="Zoom in" onClick={() => (feed.window.value = zoomed(feed.window.peek(), 0.5, 0.5))}>
        +
      </button>
      <button type="button" aria-label="Zoom out" onClick={() => (feed.window.value = zoomed(feed.window.peek(), 2, 0.5))}>
        −
      </button>
      <button type="button" disabled={end_s === null && span_s === SPAN_S} onClick={() => (feed.window.value = { span_s: SPAN_S, end_s: null })}>
        Last second
      </button>
      <span class="soft">
        {timeText(span_s)}
        {end_s === null ? "" : `, up to ${end_s.toFixed(6)} s`}
      </span>
    </div>
  );
}

/** Drags move the window; a click chooses the packet there. */
function pointing(feed: WireFeed, choose: (packet: WirePacket) => void) {
  let from: { x: number; now_s: number; end_s: number; isDrag: boolean } | undefined;
  return {
    onPointerDown: (event: PointerEvent) => {
      if (event.button !== 0) return;
      const { to_s, now_s } = lineOf(feed);
      from = { x: event.clientX, now_s, end_s: to_s, isDrag: false };
      const element = event.currentTarget as HTMLCanvasElement;
      const { span_s } = feed.window.peek();
      const onMove = (at: PointerEvent) => {
        if (!from) return;
        from.isDrag = from.isDrag || Math.abs(at.clientX - from.x) > DRAG_PX;
        if (!from.isDrag) return;
        const parts = (from.x - at.clientX) / Math.max(element.clientWidth - labelOf(element), 1);
        feed.window.value = moved({ span_s, end_s: from.end_s }, parts, from.now_s, feed.source.log.at(0)?.at_s ?? 0);
      };
      const onUp = (at: PointerEvent) => {
        element.ownerDocument.removeEventListener("pointermove", onMove);
        element.ownerDocument.removeEventListener("pointerup", onUp);
        const found = from && !from.isDrag ? packetAt(feed, element, at) : undefined;
        from = undefined;
        if (found) choose(found);
      };
      element.ownerDocument.addEventListener("pointermove", onMove);
      element.ownerDocument.addEventListener("pointerup", onUp);
    },
  };
}

/** Packet of the lane under the pointer, at most some pixels away. */
function packetAt(feed: WireFeed, element: HTMLCanvasElement, event: PointerEvent): WirePacket | undefined {
  const at = placeIn(element, event.clientX);
  const lane = Math.floor((event.clientY - element.getBoundingClientRect().top) / LANE_PX);
  const near = DRAG_PX / Math.max(element.clientWidth, 1);
  const away = ({ begin, end }: { begin: number; end: number }) => Math.max(begin - at, at - end, 0);
  const bars = lineOf(feed).line.bars.filter((bar) => bar.lane === lane && away(bar) <= near);
  return bars.sort((one, other) => away(one) - away(other))[0]?.packet;
}

function labelOf(element: HTMLElement): number {
  return Math.min(LABEL_PX, element.clientWidth / 3);
}

function placeIn(element: HTMLElement, x: number): number {
  const label = labelOf(element);
  return (x - element.getBoundingClientRect().left - label) / Math.max(element.clientWidth - label, 1);
}

/** Draw the lanes. `now_s`: the present, where the line ends with it. */
function draw(canvas: HTMLCanvasElement, line: TimeLine, to_s: number, span_s: number, now_s: number | null, chosen: number | undefined): void {
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
  const left = labelOf(canvas);
  const span = width - left;
  const bottom = line.lanes.length * LANE_PX;
  drawScale(context, left, span, bottom, to_s, span_s, now_s, colours);
  context.textAlign = "left";
  line.lanes.forEach((name, lane) => {
    context.fillStyle = colours.soft;
    context.fillText(fitted(context, name, left - 6), 0, lane * LANE_PX + 13);
    context.fillStyle = colours.grid;
    context.fillRect(left, (lane + 1) * LANE_PX - 1, span, 1);
  });
  for (const { begin, end } of line.collisions) {
    context.fillStyle = colours.badBand;
    context.fillRect(left + begin * span, 0, Math.max((end - begin) * span, LEAST_PX), bottom);
  }
  for (const { packet, lane, begin, end } of line.bars) {
    const x = left + begin * span;
    const wide = Math.max((end - begin) * span, LEAST_PX);
    context.fillStyle = packet.error === null ? colours.traces[lane % colours.traces.length]! : colours.bad;
    context.fillRect(x, lane * LANE_PX + 3, wide, LANE_PX - 6);
    if (packet.number !== chosen) continue;
    context.fillStyle = colours.ink;
    context.fillRect(x - 1, lane * LANE_PX, wide + 2, 2);
    context.fillRect(x - 1, (lane + 1) * LANE_PX - 2, wide + 2, 2);
  }
  drawEdges(context, line, left, span, bottom, colours.bad);
}

/** Draw where collisions begin and end, across all lanes: exactly, and a pixel wide at least. */
function drawEdges(context: CanvasRenderingContext2D, line: TimeLine, left: number, span: number, bottom: number, colour: string): void {
  context.fillStyle = colour;
  for (const { begin, end } of line.collisions) {
    const x = left + begin * span;
    const wide = Math.max((end - begin) * span, LEAST_PX);
    context.fillRect(x, 0, LEAST_PX, bottom);
    if (wide > 2 * LEAST_PX) context.fillRect(x + wide - LEAST_PX, 0, LEAST_PX, bottom);
    context.fillRect(x, 0, wide, 1);
    context.fillRect(x, bottom - 1, wide, 1);
  }
}

function drawScale(
  context: CanvasRenderingContext2D,
  left: number,
  span: number,
  bottom: number,
  to_s: number,
  span_s: number,
  now_s: number | null,
  colours: ReturnType<typeof palette>,
): void {
  const shift_s = now_s ?? 0;
  const { times_s, step_s } = marksOf(to_s - span_s - shift_s, to_s - shift_s, Math.floor(span / TICK_PX));
  const isFine = now_s !== null && step_s < 0.1;
  const digits = Math.max(0, Math.ceil(-Math.log10(step_s * (isFine ? 1000 : 1)) - 1e-6));
  for (const time_s of times_s) {
    const x = left + ((time_s + shift_s - to_s + span_s) / span_s) * span;
    context.fillStyle = colours.grid;
    context.fillRect(Math.min(x, left + span - 1), 0, 1, bottom);
    context.fillStyle = colours.soft;
    const isNow = now_s !== null && Math.abs(time_s) < step_s / 1000;
    const text = isNow ? "now" : `${(time_s * (isFine ? 1000 : 1)).toFixed(digits).replace("-", "−")} ${isFine ? "ms" : "s"}`;
    const half = context.measureText(text).width / 2;
    context.textAlign = "center";
    context.fillText(text, Math.min(Math.max(x, left + half), left + span - half), bottom + 14);
  }
}

function fitted(context: CanvasRenderingContext2D, text: string, width: number): string {
  if (context.measureText(text).width <= width) return text;
  let cut = text;
  while (cut && context.measureText(`${cut}…`).width > width) cut = cut.slice(0, -1);
  return `${cut}…`;
}
