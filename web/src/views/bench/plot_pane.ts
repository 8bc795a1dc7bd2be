/** A uPlot of the fields of one unit. It draws from arrays of a fixed length that are filled again: no memory is
 * taken per frame. */

import uPlot from "uplot";
import { ownerOf } from "../../model/axis_card";
import type { FaultMark } from "../../model/fault_marks";
import { beside, copyWhere, niceRange, widen } from "../../model/decimate";
import { palette } from "../../parts/palette";
import { type Drawer, onFrames, Sight, slot } from "../../parts/frames";
import type { Ring } from "../../model/ring";
import { plotMarks, type PlotMark, shownFaults } from "../../past";
import { besideOf, type Pane, rangeKey, unitIn } from "./axis_fields";
import type { PlotModel } from "./plot_model";
import { triggerOf } from "./plot_trigger";

/** An axis shows at least so much, by its unit. */
export const LEAST_SPAN: Record<string, number> = { deg: 1, rpm: 1, Nm: 0.01, A: 0.1, V: 1 };
const AXIS_LEFT_PX = 78;
const AXIS_RIGHT_PX = 66;
const PADDING_RIGHT_PX = 24;
const FONT_PX = 11;
/** Room for the names of faults above the first pane. */
const LANE_PX = 16;
const OTHERS_PX = 3;
const LEVEL_DASH_PX = 10;
/** A plot that moves is drawn again after a pixel; all panes in the same frames, so often. */
const EVERY_MS = 1000 / 16;
const MARK_CHARACTERS = 20;
const NO_GAPS: [number, number][] = [];

export class PlotPane implements Drawer {
  readonly plot: uPlot;
  private readonly sight: Sight;
  private readonly resize: ResizeObserver;
  private readonly endFrames: () => void;
  private all: Float64Array[] = [];
  private data: uPlot.TypedArray[] = [];
  /** Modes of another axis, beside its field that is drawn. */
  private modes = new Float64Array(0);
  private readonly x = { min: 0, max: 1 };
  private readonly y: [number, number] = [0, 1];
  private readonly right: [number, number] = [0, 1];
  private readonly values: [number, number] = [0, 0];
  /** Width of its place: looking at the place itself would lay the page out, each time it is asked whether it is due. */
  private width_px = 0;
  /** Called with each drawing: what stands beside it changes in the same frame. */
  onDrawn: () => void = () => undefined;
  private drawnSlot = NaN;
  private drawnTotal = -1;
  private drawnRing: Ring | null = null;
  private drawnChanges = -1;

  constructor(
    readonly place: HTMLElement,
    readonly pane: Pane,
    private readonly model: PlotModel,
    private readonly isFirst: boolean,
    hasTimes: boolean,
    /** Whether any pane has a right axis: all leave room for it, so that their times stand below one another. */
    private readonly isNarrow: boolean,
  ) {
    this.takeRows(performance.now());
    this.plot = new uPlot(this.options(hasTimes), this.data as unknown as uPlot.AlignedData, place);
    this.sight = new Sight(place);
    this.resize = new ResizeObserver(() => this.fit());
    this.resize.observe(place);
    this.endFrames = onFrames(this);
    if (hasTimes) this.dragTimes();
  }

  /** Move the time by a drag of its axis. */
  private dragTimes(): void {
    const axis = this.place.querySelector<HTMLElement>(".u-axis");
    axis?.addEventListener("pointerdown", (event) => axis.setPointerCapture(event.pointerId));
    axis?.addEventListener("pointermove", (event) => {
      if (event.buttons & 1 && event.movementX) this.model.pan(-event.movementX / Math.max(this.plot.over.clientWidth, 1));
    });
  }

  end(): void {
    this.endFrames();
    this.resize.disconnect();
    this.sight.end();
    this.plot.destroy();
  }

  /** Live plots are drawn again when they have moved by more than a pixel: those of minutes a few times a second. */
  isDue(): boolean {
    if (!this.sight.isIn) return false;
    const { ring } = this.model.shownLayer(performance.now());
    if (ring !== this.drawnRing || this.model.changes !== this.drawnChanges) return true;
    if (this.model.paused.peek()) return ring.total !== this.drawnTotal;
    if (slot(EVERY_MS) === this.drawnSlot) return false;
    const pixel_s = (this.x.max - this.x.min) / Math.max(this.width_px, 1);
    return !(Math.abs(this.model.feed.edge_s(performance.now()) - this.x.max) < pixel_s);
  }

  draw(now_ms: number): void {
    if (!this.takeRows(now_ms)) return;
    this.fillIn();
    this.scale(this.y, this.pane.unit, false);
    if (this.pane.rightUnit !== undefined) this.scale(this.right, this.pane.rightUnit, true);
    this.plot.setData(this.data as unknown as uPlot.AlignedData, false);
    this.plot.setScale("x", this.x);
    this.onDrawn();
  }

  /** Set the range of an axis: the fixed one, or what holds its lines. */
  private scale(range: [number, number], unit: string, isRight: boolean): void {
    const fixed = this.model.fixed.peek().get(rangeKey(this.pane, isRight));
    if (fixed) {
      [range[0], range[1]] = fixed;
      return;
    }
    this.values[0] = Infinity;
    this.values[1] = -Infinity;
    this.pane.fields.forEach((field, at) => {
      if (field.isRight === isRight) widen(this.data[at + 1]!, this.model.rows.made, this.values);
    });
    niceRange(this.values[0], this.values[1], LEAST_SPAN[unit] ?? 1, range);
  }

  /** Have the rows of what is shown; false: there are none. */
  private takeRows(now_ms: number): boolean {
    const layer = this.model.shownLayer(now_ms);
    const { rows } = this.model;
    this.drawnRing = layer.ring;
    this.drawnTotal = layer.ring.total;
    this.drawnChanges = this.model.changes;
    this.drawnSlot = slot(EVERY_MS);
    const right = this.model.right_s(now_ms);
    const isThere = layer.ring.total > 0 && right === right;
    if (isThere) {
      this.x.min = this.model.left_s(now_ms);
      this.x.max = right;
    }
    rows.of(layer, this.x.min, this.x.max);
    if (rows.data !== this.all) {
      this.all = rows.data;
      this.data = this.pick();
    }
    return isThere;
  }

  /** Range of values that an axis shows. */
  rangeOf(isRight: boolean): readonly [number, number] {
    return isRight ? this.right : this.y;
  }

  /** Time at the mouse, or null where it is not over the plot. */
  hovered_s(): number | null {
    const left = this.plot.cursor.left ?? -1;
    return left >= 0 ? this.plot.posToVal(left, "x") : null;
  }

  private pick(): uPlot.TypedArray[] {
    const { feed } = this.model;
    const columns = this.pane.fields.map((field) => {
      if (besideOf(field.name)) return new Float64Array(this.all[0]!.length);
      const all = this.all[feed.column(field.name)] ?? this.all[0]!;
      const isSplit = this.model.isByMode(field.name) && feed.column("mode") in this.all && feed.column("mode") > 0;
      return isSplit ? new Float64Array(all.length) : all;
    });
    return [this.all[0]!, ...columns];
  }

  /** Fill in what other axes have, and leave out what had another unit than this pane's when it was sampled. */
  private fillIn(): void {
    const { feed } = this.model;
    this.pane.fields.forEach((field, at) => {
      const out = this.data[at + 1] as Float64Array;
      const isOwn = (mode: number) => !Number.isNaN(mode) && unitIn(mode) === field.unit;
      if (besideOf(field.name)) {
        this.takeBeside(field.name, out);
        if (!this.model.isByMode(field.name)) return;
        if (this.modes.length !== out.length) this.modes = new Float64Array(out.length);
        this.takeBeside(this.model.modeNameOf(field.name), this.modes);
        copyWhere(out, this.modes, isOwn, out);
        return;
      }
      const all = this.all[feed.column(field.name)] ?? this.all[0]!;
      if (out !== all) copyWhere(all, this.all[feed.column("mode")]!, isOwn, out);
    });
  }

  /** Take what another axis has at the times of this one's rows. */
  private takeBeside(name: string, out: Float64Array): void {
    const { layer, column } = this.model.placeOf(name, this.x.min);
    beside(layer.ring, column, this.all[0]!, this.model.rows.made, out);
  }

  private fit(): void {
    const width = this.place.clientWidth;
    const height = this.place.clientHeight;
    this.width_px = width;
    if (width > 0 && (width !== this.plot.width || height !== this.plot.height)) this.plot.setSize({ width, height });
    this.drawnChanges = -1;
  }

  private options(hasTimes: boolean): uPlot.Options {
    const colours = palette();
    const font = `${FONT_PX}px ${colours.mono}`;
    const hasRight = this.pane.rightUnit !== undefined;
    const axis = { stroke: colours.soft, font, grid: { stroke: colours.grid, width: 1 }, ticks: { stroke: colours.line, width: 1, size: 4 } };
    return {
      width: Math.max(this.place.clientWidth, 100),
      height: Math.max(this.place.clientHeight, 60),
      legend: { show: false },
      padding: [this.isFirst ? LANE_PX : 6, PADDING_RIGHT_PX + (this.isNarrow && !hasRight ? AXIS_RIGHT_PX : 0), hasTimes ? 0 : 4, 0],
      scales: {
        x: { time: false },
        y: { range: () => this.y },
        ...(hasRight ? { right: { range: () => this.right } } : {}),
      },
      axes: [
        { ...axis, size: hasTimes ? 24 : 0, space: 70, values: hasTimes ? (_plot, splits) => timeTexts(splits) : () => [] },
        { ...axis, size: AXIS_LEFT_PX, space: 26 },
        ...(hasRight ? [{ ...axis, scale: "right", side: 1, size: AXIS_RIGHT_PX, space: 26, grid: { show: false } }] : []),
      ],
      series: [
        {},
        ...this.pane.fields.map((field, at) => ({
          label: field.name,
          scale: field.isRight ? "right" : "y",
          stroke: colours.traces[at % colours.traces.length]!,
          width: 1,
          points: { show: false },
          gaps: (plot: uPlot, index: number, first: number, last: number) => gapsOf(plot, index, first, last),
        })),
      ],
      cursor: {
        sync: { key: `plot ${this.model.id}` },
        points: { show: false },
        drag: { x: true, y: false, setScale: false },
        bind: { dblclick: () => () => (this.model.toPresent(), null) },
      },
      hooks: {
        drawClear: [(plot) => (this.drawFaults(plot), this.drawMarks(plot))],
        draw: [(plot) => (this.drawNames(plot), this.drawCursors(plot))],
        setSelect: [(plot) => this.zoomToSelected(plot)],
      },
    };
  }

  private zoomToSelected(plot: uPlot): void {
    const { left, width } = plot.select;
    if (width < 4) return;
    this.model.show(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  }

  /** Draw the faults below the lines: a band for the time of each of this device, one for all that overlap; a line at the
   * upper edge for the others. */
  private drawFaults(plot: uPlot): void {
    const { top, height } = plot.bbox;
    const { ctx } = plot;
    const colours = palette();
    let banded = -Infinity;
    this.eachMark(plot, top, (mark, from, to) => {
      const end = Math.max(to, from + 2);
      const isOwn = this.isOwn(mark);
      if (!isOwn) {
        ctx.fillStyle = colours.soft;
        ctx.fillRect(from, top, end - from, OTHERS_PX * devicePixelRatio);
        return;
      }
      ctx.fillStyle = colours.badBand;
      if (end > banded) ctx.fillRect(Math.max(from, banded), top, end - Math.max(from, banded), height);
      banded = Math.max(banded, end);
      ctx.fillStyle = colours.bad;
      ctx.fillRect(from, top, 1.5 * devicePixelRatio, height);
    });
  }

  /** Draw what happened as thin lines. */
  private drawMarks(plot: uPlot): void {
    const { top, height } = plot.bbox;
    plot.ctx.fillStyle = palette().line;
    for (const { at_s } of this.marksInSight()) plot.ctx.fillRect(plot.valToPos(at_s, "x", true), top, devicePixelRatio, height);
  }

  private marksInSight(): PlotMark[] {
    return plotMarks.peek().filter(({ at_s }) => at_s >= this.x.min && at_s <= this.x.max);
  }

  /** Write the faults' names above the first pane, side by side, and what else happened where there is room. */
  private drawNames(plot: uPlot): void {
    if (!this.isFirst) return;
    const { left, top, width } = plot.bbox;
    const { ctx } = plot;
    const colours = palette();
    let free = left;
    ctx.textAlign = "left";
    ctx.textBaseline = "alphabetic";
    this.eachMark(plot, 0, (mark, from) => {
      const isOwn = this.isOwn(mark);
      const text = isOwn ? mark.kind : `${mark.kind} ${mark.target}`;
      ctx.font = `${FONT_PX * devicePixelRatio}px ${colours.mono}`;
      ctx.fillStyle = isOwn ? colours.bad : colours.soft;
      const at = Math.max(from, free);
      ctx.fillText(text, at, top - 4 * devicePixelRatio);
      free = at + ctx.measureText(text).width + 8 * devicePixelRatio;
    });
    ctx.fillStyle = colours.soft;
    ctx.font = `${FONT_PX * devicePixelRatio}px ${colours.mono}`;
    for (const { at_s, text: whole } of this.marksInSight()) {
      const text = whole.length > MARK_CHARACTERS ? `${whole.slice(0, MARK_CHARACTERS - 1)}…` : whole;
      const at = plot.valToPos(at_s, "x", true);
      const end = at + ctx.measureText(text).width;
      if (at < free || end > left + width) continue;
      ctx.fillText(text, at, top - 4 * devicePixelRatio);
      free = end + 8 * devicePixelRatio;
    }
  }

  /** Draw each fault that is in sight, clipped below `from_y`: from and to in pixels of the canvas, the earliest first. */
  private eachMark(plot: uPlot, from_y: number, draw: (mark: FaultMark, from: number, to: number) => void): void {
    const marks = shownFaults.peek();
    if (!marks.length) return;
    const { left, top, width, height } = plot.bbox;
    plot.ctx.save();
    plot.ctx.beginPath();
    plot.ctx.rect(left, from_y, width, top + height - from_y);
    plot.ctx.clip();
    for (const mark of [...marks].sort((a, b) => a.begin_s - b.begin_s)) {
      const end_s = mark.end_s ?? Infinity;
      if (end_s < this.x.min || mark.begin_s > this.x.max) continue;
      const from = mark.begin_s < this.x.min ? left - 2 : plot.valToPos(mark.begin_s, "x", true);
      draw(mark, from, end_s > this.x.max ? left + width : plot.valToPos(end_s, "x", true));
    }
    plot.ctx.restore();
  }

  private isOwn(mark: FaultMark): boolean {
    return ownerOf(mark.target) === ownerOf(this.model.axis);
  }

  private drawCursors(plot: uPlot): void {
    const { ink, accent } = palette();
    this.drawCursor(plot, this.model.triggered_s.peek(), "T", accent);
    this.drawCursor(plot, this.model.cursorA.peek(), "A", ink);
    this.drawCursor(plot, this.model.cursorB.peek(), "B", ink);
    this.drawLevel(plot);
  }

  /** Draw the level of a trigger that is set at a field of this pane. */
  private drawLevel(plot: uPlot): void {
    const trigger = triggerOf(this.model);
    const { on, level } = trigger.settings.peek();
    const field = this.pane.fields.find(({ name }) => this.model.addressOf(name) === trigger.signal);
    if (!trigger.isOn || on !== "field" || !field) return;
    const { left, top, width, height } = plot.bbox;
    const at = Math.round(plot.valToPos(level, field.isRight ? "right" : "y", true));
    if (at < top || at > top + height) return;
    plot.ctx.fillStyle = palette().accent;
    for (let x = 0; x < width; x += LEVEL_DASH_PX * devicePixelRatio) {
      plot.ctx.fillRect(left + x, at, (LEVEL_DASH_PX / 2) * devicePixelRatio, devicePixelRatio);
    }
  }

  private drawCursor(plot: uPlot, time_s: number | null, name: string, colour: string): void {
    if (time_s === null || time_s < this.x.min || time_s > this.x.max) return;
    const { top, height } = plot.bbox;
    const at = Math.round(plot.valToPos(time_s, "x", true));
    const colours = palette();
    const context = plot.ctx;
    context.save();
    context.fillStyle = colour;
    context.fillRect(at, top, devicePixelRatio, height);
    context.font = `bold ${FONT_PX * devicePixelRatio}px ${colours.mono}`;
    context.textAlign = "left";
    context.fillText(name, at + 3 * devicePixelRatio, top + height - 4 * devicePixelRatio);
    context.restore();
  }
}

/** Write times so that neighbours differ. */
function timeTexts(splits: number[]): string[] {
  const step_s = (splits[1] ?? NaN) - (splits[0] ?? NaN);
  const digits = step_s > 0 ? Math.min(Math.max(Math.ceil(-Math.log10(step_s) - 1e-9) + 1, 1), 7) : 4;
  // Before 0 is the run before this one, whose clock was another.
  return splits.map((value) => (value < 0 ? "" : `${+value.toFixed(digits)} s`));
}

/** Gaps of a line: where values are missing. Made only if there are any. */
function gapsOf(plot: uPlot, index: number, first: number, last: number): [number, number][] {
  const values = plot.data[index] as ArrayLike<number>;
  const times = plot.data[0];
  let gaps = NO_GAPS;
  for (let at = first; at <= last; at++) {
    const value = values[at]!;
    if (value === value) continue;
    let end = at;
    while (end < last && values[end]! !== values[end]!) end++;
    if (gaps === NO_GAPS) gaps = [];
    gaps.push([plot.valToPos(times[Math.max(at - 1, first)]!, "x", true), plot.valToPos(times[end]!, "x", true)]);
    at = end;
  }
  return gaps;
}
