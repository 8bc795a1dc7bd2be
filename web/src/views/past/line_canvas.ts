/** Lanes of marks over the time of a run, on a canvas. */

import { LANES, type PastMark, ticks, timeText } from "../../model/past";
import { palette } from "../../parts/palette";

const LANE_PX = 13;
const AXIS_PX = 18;
const NEAR_PX = 4;
const TICK_PX = 110;

export interface Shown {
  marks: readonly PastMark[];
  from_s: number;
  to_s: number;
  end_s: number;
  ready_s: number;
  at_s: number | null;
}

export class LineCanvas {
  private readonly context: CanvasRenderingContext2D | null;
  private readonly resize: ResizeObserver;
  private shown: Shown | null = null;

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.context = canvas.getContext("2d");
    this.resize = new ResizeObserver(() => this.draw());
    this.resize.observe(canvas);
  }

  end(): void {
    this.resize.disconnect();
  }

  show(shown: Shown): void {
    this.shown = shown;
    this.draw();
  }

  /** Mark at a place in pixels. */
  markAt(x: number, y: number): PastMark | undefined {
    const { shown } = this;
    const lane = this.lanes()[Math.floor(y / LANE_PX)];
    if (!shown || lane === undefined) return undefined;
    const near = shown.marks.filter((mark) => mark.lane === lane && this.xOf(mark.from_s) - NEAR_PX <= x && x <= this.xOf(mark.to_s ?? shown.end_s) + NEAR_PX);
    return near.at(-1);
  }

  /** Lanes that have marks, from the top. */
  private lanes(): string[] {
    const there = new Set(this.shown?.marks.map((mark) => mark.lane));
    return LANES.filter((lane) => there.has(lane));
  }

  private xOf(at_s: number): number {
    const { from_s, to_s } = this.shown!;
    return ((at_s - from_s) / (to_s - from_s)) * this.canvas.clientWidth;
  }

  private draw(): void {
    const { context, shown, canvas } = this;
    if (!context || !shown) return;
    const lanes = this.lanes();
    const height = Math.max(lanes.length, 1) * LANE_PX + AXIS_PX;
    const width = canvas.clientWidth;
    const scale = devicePixelRatio;
    canvas.style.height = `${height}px`;
    if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) {
      canvas.width = Math.round(width * scale);
      canvas.height = Math.round(height * scale);
    }
    const colours = palette();
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, width, height);
    context.fillStyle = colours.grid;
    context.fillRect(0, 0, Math.min(this.xOf(shown.ready_s), width), height - AXIS_PX);
    this.drawTimes(context, shown, width, height);
    for (const mark of shown.marks) this.drawMark(context, mark, lanes.indexOf(mark.lane));
    this.drawNames(context, lanes);
    const x = Math.min(this.xOf(shown.at_s ?? shown.end_s), width - 2);
    context.fillStyle = shown.at_s === null ? colours.soft : colours.accent;
    context.fillRect(x - 1, 0, 2, height);
  }

  private drawMark(context: CanvasRenderingContext2D, mark: PastMark, lane: number): void {
    const colours = palette();
    const isBad = mark.lane === "faults" || mark.lane === "stops" || mark.lane === "trouble" || mark.lane === "refusals";
    const from = this.xOf(mark.from_s);
    const to = this.xOf(mark.to_s ?? this.shown!.end_s);
    context.fillStyle = isBad ? colours.bad : colours.traces[LANES.indexOf(mark.lane as (typeof LANES)[number]) % colours.traces.length]!;
    context.fillRect(from, lane * LANE_PX + 1, Math.max(to - from, 2), LANE_PX - 2);
  }

  /** Names of the lanes, with a rim: marks may be behind them. */
  private drawNames(context: CanvasRenderingContext2D, lanes: string[]): void {
    const colours = palette();
    context.lineWidth = 3;
    context.lineJoin = "round";
    context.strokeStyle = colours.grid;
    context.fillStyle = colours.soft;
    for (const [at, lane] of lanes.entries()) {
      context.strokeText(lane, 4, (at + 1) * LANE_PX - 3);
      context.fillText(lane, 4, (at + 1) * LANE_PX - 3);
    }
  }

  private drawTimes(context: CanvasRenderingContext2D, shown: Shown, width: number, height: number): void {
    const colours = palette();
    context.font = `11px ${colours.mono}`;
    context.textBaseline = "alphabetic";
    let end = -Infinity;
    for (const at of ticks(shown.from_s, shown.to_s, Math.max(width / TICK_PX, 1))) {
      const x = this.xOf(at);
      context.fillStyle = colours.line;
      context.fillRect(x, height - AXIS_PX, 1, 5);
      context.fillStyle = colours.soft;
      const text = timeText(at);
      const wide = context.measureText(text).width;
      const from = Math.min(Math.max(x - wide / 2, 0), width - wide);
      if (from < end) continue;
      context.fillText(text, from, height - 3);
      end = from + wide + NEAR_PX;
    }
  }
}
