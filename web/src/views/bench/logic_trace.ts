/** A level over time on a small canvas, as a logic analyser draws it. Values of several bits stand as numbers. */

import { type Drawer, onFrames, Sight } from "../../parts/frames";
import { palette } from "../../parts/palette";
import type { Ring } from "../../model/ring";
import type { AxisFeed } from "./axis_feed";
import { levelOf } from "./axis_fields";

const WINDOW_s = 5;
const MARGIN = 0.2;
const LEAST_TEXT_PX = 14;

export class LogicTrace implements Drawer {
  private readonly context: CanvasRenderingContext2D | null;
  private readonly sight: Sight;
  private readonly resize: ResizeObserver;
  private readonly endFrames: () => void;
  private drawnEdge_s = NaN;
  private drawnRing: Ring | null = null;
  /** Whether there was a level before, from which an edge comes. */
  private isEdge = false;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly feed: AxisFeed,
    private readonly field: string,
    private readonly bit: number | null,
  ) {
    this.context = canvas.getContext("2d");
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
    const isMoved = this.feed.edge_s(performance.now()) !== this.drawnEdge_s || this.feed.ring !== this.drawnRing;
    return this.sight.isIn && this.feed.ring.total > 0 && isMoved;
  }

  draw(now_ms: number): void {
    const context = this.context;
    if (!context) return;
    const { ring } = this.feed;
    const column = this.feed.column(this.field);
    const { width, height } = this.canvas;
    const to_s = this.feed.edge_s(now_ms);
    this.drawnEdge_s = to_s;
    this.drawnRing = ring;
    const scale = width / WINDOW_s;
    const xOf = (index: number) => Math.max(0, (ring.at(0, index) - to_s + WINDOW_s) * scale);
    context.clearRect(0, 0, width, height);
    context.strokeStyle = context.fillStyle = palette().traces[0]!;
    context.lineWidth = 1.25 * devicePixelRatio;
    context.font = `${10 * devicePixelRatio}px ${palette().mono}`;
    context.beginPath();
    this.isEdge = false;
    let index = Math.max(ring.indexAt(to_s - WINDOW_s) - 1, ring.first);
    while (index < ring.total) {
      const value = levelOf(ring.at(column, index), this.bit);
      let end = index + 1;
      while (end < ring.total && levelOf(ring.at(column, end), this.bit) === value) end++;
      const from = xOf(index);
      const to = end < ring.total ? xOf(end) : width;
      if (value === value) this.span(context, value, from, to, height);
      this.isEdge = value === value;
      index = end;
    }
    context.stroke();
  }

  private span(context: CanvasRenderingContext2D, value: number, from: number, to: number, height: number): void {
    const top = height * MARGIN;
    const bottom = height * (1 - MARGIN);
    const edge = from > 0 && this.isEdge;
    if (value === 0 || value === 1) {
      const y = value ? top : bottom;
      if (edge) context.moveTo(from, value ? bottom : top);
      else context.moveTo(from, y);
      context.lineTo(from, y);
      context.lineTo(to, y);
      return;
    }
    context.rect(from, top, to - from, bottom - top);
    if (to - from > LEAST_TEXT_PX * devicePixelRatio) context.fillText(String(value), from + 4, bottom - 3 * devicePixelRatio);
  }

  private fit(): void {
    this.canvas.width = Math.round(this.canvas.clientWidth * devicePixelRatio);
    this.canvas.height = Math.round(this.canvas.clientHeight * devicePixelRatio);
    this.drawnEdge_s = NaN;
  }
}
