/** One signal over another on a canvas: the older, the paler; a mark where it is now, and at the cursors. */

import { niceStep } from "../../model/decimate";
import { nearestTime, valueAt, type XyRanges, xyPoints, xyRanges, xyRoom, type XySource } from "../../model/xy";
import { type Drawer, onFrames, Sight } from "../../parts/frames";
import { type Palette, palette } from "../../parts/palette";
import { theme } from "../../theme";
import { LEAST_SPAN } from "./plot_pane";
import type { PlotModel } from "./plot_model";

const MOST_POINTS = 12_000;
/** Lines of the path, each of one colour: from the oldest to the newest. */
const SHADES = 24;
const PALEST = 0.15;
const LEFT_PX = 70;
const BOTTOM_PX = 34;
const TOP_PX = 10;
const RIGHT_PX = 16;
const TICK_PX = 60;
const FONT_PX = 11;
const HEAD_PX = 4;

export interface XyAxis {
  /** Name of the field in the model. */
  name: string;
  label: string;
  unit: string;
}

export class XyPane implements Drawer {
  private readonly sight: Sight;
  private readonly resize: ResizeObserver;
  private readonly endFrames: () => void;
  private readonly points = xyRoom(MOST_POINTS);
  private readonly ranges: XyRanges = { x: [0, 1], y: [0, 1] };
  private drawn = "";
  /** Time from which on it is drawn, where that is later than what is shown. */
  cut_s = NaN;

  constructor(
    readonly canvas: HTMLCanvasElement,
    private readonly model: PlotModel,
    private readonly x: XyAxis,
    private readonly y: XyAxis,
    private readonly isEqual: boolean,
  ) {
    this.sight = new Sight(canvas);
    this.resize = new ResizeObserver(() => (this.drawn = ""));
    this.resize.observe(canvas);
    this.endFrames = onFrames(this);
  }

  end(): void {
    this.endFrames();
    this.sight.end();
    this.resize.disconnect();
  }

  isDue(): boolean {
    return this.sight.isIn && this.state(performance.now()) !== this.drawn;
  }

  private state(now_ms: number): string {
    const { model, canvas } = this;
    const { ring } = model.shownLayer(now_ms);
    return `${ring.total} ${model.right_s(now_ms)} ${model.left_s(now_ms)} ${model.changes} ${canvas.clientWidth} ${canvas.clientHeight} ${theme.peek()}`;
  }

  private source(name: string, from_s: number): XySource {
    const { layer, column } = this.model.placeOf(name, from_s);
    return { ring: layer.ring, column, isExtremes: layer.sampling.isExtremes };
  }

  /** Time of the point next to a place in pixels; NaN: there is none. */
  timeAt(left: number, top: number): number {
    const [wide, high] = this.room();
    const part = (range: readonly [number, number], at: number) => range[0] + (range[1] - range[0]) * at;
    return nearestTime(this.points, this.ranges, part(this.ranges.x, (left - LEFT_PX) / wide), part(this.ranges.y, 1 - (top - TOP_PX) / high));
  }

  private room(): [number, number] {
    return [Math.max(this.canvas.clientWidth - LEFT_PX - RIGHT_PX, 10), Math.max(this.canvas.clientHeight - TOP_PX - BOTTOM_PX, 10)];
  }

  draw(now_ms: number): void {
    const { canvas, model } = this;
    const context = canvas.getContext("2d");
    if (!context || !canvas.clientWidth) return;
    this.drawn = this.state(now_ms);
    const scale = devicePixelRatio;
    const [width, height] = [Math.round(canvas.clientWidth * scale), Math.round(canvas.clientHeight * scale)];
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const from_s = model.left_s(now_ms);
    const begin_s = xyPoints(this.source(this.x.name, from_s), this.source(this.y.name, from_s), from_s, model.right_s(now_ms), this.points);
    this.cut_s = this.points.count === MOST_POINTS || this.points.count >= MOST_POINTS - 1 ? begin_s : NaN;
    const least = [LEAST_SPAN[this.x.unit] ?? 1, LEAST_SPAN[this.y.unit] ?? 1] as const;
    xyRanges(this.points, least, this.isEqual ? this.room() : null, this.ranges);
    const colours = palette();
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
    context.font = `${FONT_PX}px ${colours.mono}`;
    this.drawAxes(context, colours);
    this.drawPath(context, colours);
    this.drawMarks(context, colours, from_s);
  }

  private xOf(value: number): number {
    const [low, high] = this.ranges.x;
    return LEFT_PX + ((value - low) / (high - low)) * this.room()[0];
  }

  private yOf(value: number): number {
    const [low, high] = this.ranges.y;
    return TOP_PX + (1 - (value - low) / (high - low)) * this.room()[1];
  }

  private drawAxes(context: CanvasRenderingContext2D, colours: Palette): void {
    const [wide, high] = this.room();
    const bottom = TOP_PX + high;
    context.textBaseline = "middle";
    context.textAlign = "center";
    for (const [value, text] of ticksOf(this.ranges.x, wide / TICK_PX)) {
      context.fillStyle = colours.grid;
      context.fillRect(Math.round(this.xOf(value)), TOP_PX, 1, high);
      context.fillStyle = colours.soft;
      context.fillText(text, this.xOf(value), bottom + 10);
    }
    context.textAlign = "right";
    for (const [value, text] of ticksOf(this.ranges.y, (2 * high) / TICK_PX)) {
      context.fillStyle = colours.grid;
      context.fillRect(LEFT_PX, Math.round(this.yOf(value)), wide, 1);
      context.fillStyle = colours.soft;
      context.fillText(text, LEFT_PX - 5, this.yOf(value));
    }
    context.fillStyle = colours.ink;
    context.textAlign = "center";
    context.fillText(titleOf(this.x), LEFT_PX + wide / 2, bottom + 25);
    context.save();
    context.translate(9, TOP_PX + high / 2);
    context.rotate(-Math.PI / 2);
    context.fillText(titleOf(this.y), 0, 0);
    context.restore();
  }

  private drawPath(context: CanvasRenderingContext2D, colours: Palette): void {
    const { x, y, count } = this.points;
    context.save();
    context.beginPath();
    context.rect(LEFT_PX, TOP_PX, ...this.room());
    context.clip();
    context.strokeStyle = colours.traces[0]!;
    context.lineWidth = 1.2;
    context.lineJoin = "round";
    for (let shade = 0; shade < SHADES; shade++) {
      const [first, end] = [Math.floor((shade * count) / SHADES), Math.min(Math.floor(((shade + 1) * count) / SHADES) + 1, count)];
      context.globalAlpha = PALEST + ((1 - PALEST) * (shade + 1)) / SHADES;
      context.beginPath();
      let isDown = false;
      for (let at = first; at < end; at++) {
        const [left, top] = [this.xOf(x[at]!), this.yOf(y[at]!)];
        if (left !== left || top !== top) isDown = false;
        else if (isDown) context.lineTo(left, top);
        else {
          context.moveTo(left, top);
          isDown = true;
        }
      }
      context.stroke();
    }
    context.restore();
  }

  private drawMarks(context: CanvasRenderingContext2D, colours: Palette, from_s: number): void {
    const { at_s, count } = this.points;
    const { model } = this;
    if (count) this.drawMark(context, colours.accent, "", at_s[count - 1]!, from_s);
    this.drawMark(context, colours.accent, "T", model.triggered_s.peek(), from_s);
    this.drawMark(context, colours.ink, "A", model.cursorA.peek(), from_s);
    this.drawMark(context, colours.ink, "B", model.cursorB.peek(), from_s);
  }

  private drawMark(context: CanvasRenderingContext2D, colour: string, name: string, at_s: number | null, from_s: number): void {
    if (at_s === null) return;
    const left = this.xOf(valueAt(this.source(this.x.name, from_s), at_s));
    const top = this.yOf(valueAt(this.source(this.y.name, from_s), at_s));
    if (left !== left || top !== top) return;
    context.fillStyle = colour;
    context.beginPath();
    context.arc(left, top, HEAD_PX, 0, 2 * Math.PI);
    context.fill();
    context.textAlign = "left";
    context.fillText(name, left + HEAD_PX + 2, top - HEAD_PX - 2);
  }
}

function titleOf({ label, unit }: XyAxis): string {
  return unit ? `${label} (${unit})` : label;
}

/** Values at which an axis has lines, with their texts: about so many. */
function ticksOf([low, high]: readonly [number, number], about: number): [number, string][] {
  const step = niceStep((high - low) / Math.max(about, 1));
  const digits = Math.max(-Math.floor(Math.log10(step) + 1e-9), 0) + (Math.abs(step / 10 ** Math.floor(Math.log10(step)) - 2.5) < 1e-6 ? 1 : 0);
  const made: [number, string][] = [];
  for (let at = Math.ceil(low / step - 1e-9); at * step <= high + step * 1e-9; at++)
    made.push([at * step, (at * step).toFixed(Math.min(digits, 9)).replace(/^-/, "−")]);
  return made;
}
