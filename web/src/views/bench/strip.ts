/** A strip of one field on a small canvas: the least that shows how an axis moves. */

import { decimate, display, niceRange, widen } from "../../model/decimate";
import { type Drawer, onFrames, Sight, slot } from "../../parts/frames";
import { palette } from "../../parts/palette";
import type { Ring } from "../../model/ring";
import type { AxisFeed } from "./axis_feed";

const WINDOW_s = 10;
const POINTS = 300;
const LEAST_SPAN = 2;
/** Strips are drawn in the same frames, so often: each frame costs, however much is drawn in it. */
const EVERY_MS = 125;

export class Strip implements Drawer {
  private readonly context: CanvasRenderingContext2D | null;
  private readonly sight: Sight;
  private readonly resize: ResizeObserver;
  private readonly endFrames: () => void;
  private data: Float64Array[];
  private readonly range: [number, number] = [0, 1];
  private readonly values: [number, number] = [0, 0];
  private drawnEdge_s = NaN;
  private drawnSlot = NaN;
  private drawnRing: Ring | null = null;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly feed: AxisFeed,
    private readonly field: string,
    /** Called with each drawing: what stands beside it changes in the same frame. */
    private readonly onDrawn: () => void,
  ) {
    this.context = canvas.getContext("2d");
    this.data = display(feed.ring, POINTS);
    this.sight = new Sight(canvas);
    this.resize = new ResizeObserver(() => this.fit());
    this.resize.observe(canvas);
    this.endFrames = onFrames(this);
  }

  end(): void {
    this.endFrames();
    this.resize.disconnect();
    this.sight.end();
  }

  isDue(): boolean {
    if (!this.sight.isIn || !this.feed.ring.total) return false;
    if (this.feed.ring !== this.drawnRing) return true;
    if (slot(EVERY_MS) === this.drawnSlot) return false;
    const moved_s = Math.abs(this.feed.edge_s(performance.now()) - this.drawnEdge_s);
    return !(moved_s < WINDOW_s / this.canvas.width); // less than a pixel would not be seen
  }

  draw(now_ms: number): void {
    const { ring } = this.feed;
    if (this.data.length !== ring.width) this.data = display(ring, POINTS);
    const values = this.data[this.feed.column(this.field)];
    const times = this.data[0]!;
    const to_s = this.feed.edge_s(now_ms);
    this.drawnEdge_s = to_s;
    this.drawnSlot = slot(EVERY_MS);
    this.drawnRing = ring;
    const made = decimate(ring, to_s - WINDOW_s, to_s, this.data);
    if (this.context && values) this.line(this.context, times, values, made, to_s);
    this.onDrawn();
  }

  private line(context: CanvasRenderingContext2D, times: Float64Array, values: Float64Array, made: number, to_s: number): void {
    const { width, height } = this.canvas;
    this.values[0] = Infinity;
    this.values[1] = -Infinity;
    widen(values, made, this.values);
    niceRange(this.values[0], this.values[1], LEAST_SPAN, this.range);
    const scaleX = width / WINDOW_s;
    const scaleY = height / (this.range[1] - this.range[0]);
    const from_s = to_s - WINDOW_s;
    context.clearRect(0, 0, width, height);
    context.strokeStyle = palette().traces[0]!;
    context.lineWidth = 1.25 * devicePixelRatio;
    context.beginPath();
    let isDown = false;
    for (let at = 0; at < made; at++) {
      const value = values[at]!;
      if (value !== value) {
        isDown = false;
        continue;
      }
      const x = (times[at]! - from_s) * scaleX;
      const y = height - (value - this.range[0]) * scaleY;
      if (isDown) context.lineTo(x, y);
      else context.moveTo(x, y);
      isDown = true;
    }
    context.stroke();
  }

  private fit(): void {
    this.canvas.width = Math.round(this.canvas.clientWidth * devicePixelRatio);
    this.canvas.height = Math.round(this.canvas.clientHeight * devicePixelRatio);
    this.drawnEdge_s = NaN;
  }
}
