/** What is shown of one axis's plots: the time, a pause, cursors, chosen fields. It outlives the view, and all but the
 * pause the page. */

import { computed, signal } from "@preact/signals";
import { Kept, keptFor } from "../../kept";
import { windowWithin } from "../../model/decimate";
import type { DeviceRow, FieldRow } from "../../model/door";
import type { Ring } from "../../model/ring";
import { type Layer, layerOver } from "../../model/sampling";
import { hello } from "../../store";
import { feedOf } from "./axis_feed";
import { besideOf, drawable, isByMode, unitIn, usualFields } from "./axis_fields";
import { ShownRows } from "./shown_rows";

export const WINDOWS_s = [1, 2, 5, 10, 30, 60, 120, 300];

const USUAL_WINDOW_s = 10;

/** Times of both cursors, in a run of the bench: the next one has other times. */
interface Cursors {
  instance: string;
  a: number | null;
  b: number | null;
}

/** One of the cursors, as a signal. */
class Cursor {
  constructor(
    private readonly both: Kept<Cursors>,
    private readonly which: "a" | "b",
  ) {}

  get value(): number | null {
    return this.in(this.both.value, hello.value?.instance);
  }

  set value(at_s: number | null) {
    const instance = hello.peek()?.instance ?? "";
    const before = this.both.peek();
    const others = before.instance === instance ? before : { a: null, b: null };
    this.both.value = { ...others, instance, [this.which]: at_s };
  }

  peek(): number | null {
    return this.in(this.both.peek(), hello.peek()?.instance);
  }

  private in(both: Cursors, instance: string | undefined): number | null {
    return both.instance === instance ? both[this.which] : null;
  }
}

function readCursors(raw: unknown): Cursors | undefined {
  const { instance, a, b } = (raw ?? {}) as Partial<Cursors>;
  const isTime = (at_s: unknown) => at_s === null || (typeof at_s === "number" && Number.isFinite(at_s));
  return typeof instance === "string" && isTime(a) && isTime(b) ? { instance, a: a ?? null, b: b ?? null } : undefined;
}

export class PlotModel {
  readonly window_s: Kept<number>;
  /** The samples as they were when the plot was paused; null: it is live. */
  readonly paused = signal<Layer[] | null>(null);
  /** Shown time while it is paused. */
  readonly from_s = signal(0);
  readonly to_s = signal(0);
  readonly cursorA: Cursor;
  readonly cursorB: Cursor;
  readonly chosen: Kept<string[]>;
  /** Fields of other axes that are drawn, too. */
  readonly others = signal<FieldRow[]>([]);
  private othersPaused = new Map<string, Layer[]>();
  /** Fixed ranges of values by pane; the others fit what is shown. */
  readonly fixed = signal<ReadonlyMap<string, readonly [number, number]>>(new Map());
  readonly isPaused = computed(() => this.paused.value !== null);
  /** What all panes draw. */
  readonly rows = new ShownRows();
  /** Grows when something has to be drawn again although no sample came. */
  changes = 0;
  /** True once a cursor was set since the page was loaded. */
  private areCursorsSet = false;

  /** `device`: as the bench describes it now. */
  constructor(
    public device: DeviceRow,
    readonly axis = device.name,
  ) {
    this.window_s = new Kept(
      `plot.${axis}.window`,
      () => USUAL_WINDOW_s,
      (raw) => WINDOWS_s.find((each) => each === raw),
    );
    this.chosen = new Kept(
      `plot.${axis}.fields`,
      () => usualFields(this.device),
      (raw) => this.readFields(raw),
    );
    const cursors = new Kept(`plot.${axis}.cursors`, () => ({ instance: "", a: null, b: null }), readCursors);
    this.cursorA = new Cursor(cursors, "a");
    this.cursorB = new Cursor(cursors, "b");
  }

  /** Chosen fields that the device has; undefined: it is another one now, and has none of them. */
  private readFields(raw: unknown): string[] | undefined {
    if (!Array.isArray(raw)) return undefined;
    const there = drawable(this.device)
      .map(({ name }) => name)
      .filter((name) => raw.includes(name));
    return there.length || !raw.length ? there : undefined;
  }

  get feed() {
    return feedOf(this.axis);
  }

  /** Samples that may be shown, the finest first. */
  get layers(): Layer[] {
    return this.paused.peek() ?? this.feed.layers;
  }

  /** Samples for what is shown at a moment. */
  shownLayer(now_ms: number): Layer {
    return layerOver(this.layers, this.left_s(now_ms));
  }

  /** Left edge of what is shown at a moment; the right one is `right_s`. */
  left_s(now_ms: number): number {
    return this.paused.peek() ? this.from_s.peek() : this.right_s(now_ms) - this.window_s.peek();
  }

  right_s(now_ms: number): number {
    return this.paused.peek() ? this.to_s.peek() : this.feed.edge_s(now_ms);
  }

  /** Ring and column of a field, for what is shown from a time on. */
  placeOf(name: string, from_s: number): { ring: Ring; column: number } {
    const other = besideOf(name);
    if (!other) return { ring: layerOver(this.layers, from_s).ring, column: this.feed.column(name) };
    const feed = feedOf(other.axis);
    const layers = (this.paused.peek() && this.othersPaused.get(other.axis)) || feed.layers;
    return { ring: layerOver(layers, from_s).ring, column: feed.column(other.field) };
  }

  /** Value of a field at a time; NaN where it had another unit then than this, if one is given. */
  valueAt(name: string, at_s: number, unit?: string): number {
    if (unit !== undefined && this.unitAt(name, at_s, unit) !== unit) return NaN;
    const { ring, column } = this.placeOf(name, at_s);
    return column ? ring.nearest(column, at_s) : NaN;
  }

  /** Value at a cursor. A cursor of before the page was loaded may be where there are no samples: NaN. */
  valueAtCursor(name: string, at_s: number): number {
    const { ring } = layerOver(this.layers, at_s);
    const isThere = ring.total > 0 && at_s >= ring.first_s && at_s <= ring.last_s;
    return isThere || this.areCursorsSet ? this.valueAt(name, at_s) : NaN;
  }

  /** Unit that a field had at a time. */
  unitAt(name: string, at_s: number, usual: string): string {
    const column = this.feed.column("mode");
    const mode = column && isByMode(this.device, name) ? layerOver(this.layers, at_s).ring.nearest(column, at_s) : NaN;
    return Number.isNaN(mode) ? usual : unitIn(mode);
  }

  togglePause(): void {
    if (this.paused.peek()) this.live();
    else this.pause();
  }

  pause(): void {
    if (this.paused.peek()) return;
    const now_ms = performance.now();
    const right = this.right_s(now_ms);
    this.from_s.value = right - this.window_s.peek();
    this.to_s.value = right;
    const copy = (layers: Layer[]) => layers.map(({ ring, sampling }) => ({ ring: ring.copy(), sampling }));
    const axes = new Set(this.others.peek().flatMap(({ name }) => besideOf(name)?.axis ?? []));
    this.othersPaused = new Map([...axes].map((axis) => [axis, copy(feedOf(axis).layers)]));
    this.paused.value = copy(this.feed.layers);
    this.changes++;
  }

  live(): void {
    this.paused.value = null;
    this.othersPaused.clear();
    this.changes++;
  }

  show(from_s: number, to_s: number): void {
    if (!(to_s - from_s > 1e-4)) return;
    this.pause();
    const rings = this.layers.map(({ ring }) => ring).filter((ring) => ring.total > 0);
    const first_s = Math.min(this.from_s.peek(), ...rings.map((ring) => ring.first_s));
    const last_s = Math.max(this.to_s.peek(), ...rings.map((ring) => ring.last_s));
    [this.from_s.value, this.to_s.value] = windowWithin(from_s, to_s, first_s, last_s);
    this.changes++;
  }

  /** Zoom by a factor, below 1 in, around a time; live plots change their window. */
  zoom(factor: number, around_s?: number): void {
    if (!this.paused.peek()) {
      const at = WINDOWS_s.indexOf(this.window_s.peek());
      const next = WINDOWS_s[at + (factor < 1 ? -1 : 1)];
      if (next) this.window_s.value = next;
      return;
    }
    const from = this.from_s.peek();
    const to = this.to_s.peek();
    const centre = around_s ?? (from + to) / 2;
    this.show(centre - (centre - from) * factor, centre + (to - centre) * factor);
  }

  /** Move what is shown by a part of its length. */
  pan(part: number): void {
    const by = (this.to_s.peek() - this.from_s.peek()) * part;
    if (this.paused.peek()) this.show(this.from_s.peek() + by, this.to_s.peek() + by);
  }

  setCursor(isB: boolean, time_s: number | null): void {
    this.pause();
    this.areCursorsSet = true;
    (isB ? this.cursorB : this.cursorA).value = time_s;
    this.changes++;
  }

  moveCursor(isB: boolean, part: number): void {
    const cursor = isB ? this.cursorB : this.cursorA;
    this.pause();
    const from = this.from_s.peek();
    const to = this.to_s.peek();
    const at = cursor.peek() ?? (from + to) / 2;
    this.setCursor(isB, Math.min(Math.max(at + (to - from) * part, from), to));
  }

  /** Fix the range of a pane, or let it fit what is shown again. */
  fix(pane: string, range: readonly [number, number] | null): void {
    const others = [...this.fixed.peek()].filter(([key]) => key !== pane);
    this.fixed.value = new Map(range ? [...others, [pane, range] as const] : others);
    this.changes++;
  }

  /** Draw a field of another axis, too, or no longer. */
  toggleOther(field: FieldRow): void {
    const before = this.others.peek();
    const without = before.filter(({ name }) => name !== field.name);
    this.others.value = without.length < before.length ? without : [...before, field];
  }

  toggleField(name: string): void {
    const before = this.chosen.peek();
    this.chosen.value = before.includes(name) ? before.filter((field) => field !== name) : [...before, name];
  }
}

const models = new Map<string, PlotModel>();

export function plotModelOf(device: DeviceRow): PlotModel {
  const key = `${keptFor.peek()}/${device.name}`;
  let model = models.get(key);
  if (!model || model.device.profile !== device.profile) models.set(key, (model = new PlotModel(device)));
  model.device = device;
  return model;
}
