/** What is shown of one axis's plots: the time, a pause, cursors, chosen fields. It outlives the view, and all but the
 * pause the page. */

import { computed, signal } from "@preact/signals";
import { Kept, keptFor } from "../../kept";
import { windowWithin } from "../../model/decimate";
import type { DeviceRow, FieldRow } from "../../model/door";
import { type Layer, layerOver } from "../../model/sampling";
import { end_s, live, lookAt, pastAt } from "../../past";
import { devices } from "../../store";
import { feedOf } from "./axis_feed";
import { besideOf, drawable, fieldAt, fieldsBeside, isByMode, type Pane, panesOf, unitIn, usualFields } from "./axis_fields";
import { type Cursor, cursorsOf } from "./plot_cursors";
import { ShownRows } from "./shown_rows";

export const WINDOWS_s = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60, 120, 300];

export const USUAL_WINDOW_s = 10;

/** Addresses of two fields of which one is drawn over the other. */
export interface XyChoice {
  x: string;
  y: string;
  /** Whether a unit is as long in both axes. */
  isEqual: boolean;
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
  /** Fields of other axes that are drawn, too: "m2.yw". */
  readonly others: Kept<string[]>;
  /** Panes at whose right axis fields are drawn, by the fields' names. */
  readonly right: Kept<Readonly<Record<string, string>>>;
  /** A field that is drawn over another; null: none is. */
  readonly xy: Kept<XyChoice | null>;
  private othersPaused = new Map<string, Layer[]>();
  /** Fixed ranges of values by pane; the others fit what is shown. */
  readonly fixed = signal<ReadonlyMap<string, readonly [number, number]>>(new Map());
  readonly isPaused = computed(() => this.paused.value !== null);
  /** What all panes draw. */
  readonly rows = new ShownRows();
  /** Grows when something has to be drawn again although no sample came. */
  changes = 0;
  /** Time of the trigger whose picture is held; null: there is none. */
  readonly triggered_s = signal<number | null>(null);
  /** True once a cursor was set since the page was loaded. */
  private areCursorsSet = false;

  /** `device`: as the bench describes it now; `id`: name of what is kept. */
  constructor(
    public device: DeviceRow,
    readonly id = device.name,
    readonly axis = device.name,
  ) {
    this.window_s = new Kept(
      `plot.${id}.window`,
      () => USUAL_WINDOW_s,
      (raw) => WINDOWS_s.find((each) => each === raw),
    );
    this.chosen = new Kept(
      `plot.${id}.fields`,
      () => usualFields(this.device),
      (raw) => this.readFields(raw),
    );
    this.others = new Kept(`plot.${id}.others`, () => [], readOthers);
    this.right = new Kept(`plot.${id}.right`, () => ({}), readRight);
    this.xy = new Kept<XyChoice | null>(`plot.${id}.xy`, () => null, readXy);
    [this.cursorA, this.cursorB] = cursorsOf(id);
  }

  /** Chosen fields that the device has; undefined: it is another one now, and has none of them. */
  private readFields(raw: unknown): string[] | undefined {
    if (!Array.isArray(raw)) return undefined;
    const there = drawable(this.device)
      .map(({ name }) => name)
      .filter((name) => raw.includes(name));
    return there.length || !raw.length ? there : undefined;
  }

  /** Fields of other axes, as far as the bench has them. */
  otherFields(): FieldRow[] {
    return this.others.value.flatMap((name) => {
      const found = fieldAt(devices.value, name);
      return found ? fieldsBeside(found.device).filter((field) => field.name === name) : [];
    });
  }

  panes(): Pane[] {
    const others = this.otherFields().flatMap((field) => this.unitsOf(field.name, field.unit).map((unit) => ({ ...field, unit })));
    return panesOf(this.device, this.chosen.value, this.feed.modes.value, others, this.right.value);
  }

  /** Whether the unit of a field depends on the mode that its axis has at each moment. */
  isByMode(name: string): boolean {
    const other = besideOf(name);
    const device = other ? devices.peek().get(other.axis) : this.device;
    return device !== undefined && isByMode(device, other?.field ?? name);
  }

  /** Units that a field has had. */
  unitsOf(name: string, usual: string): string[] {
    const modes = this.isByMode(name) ? feedOf(besideOf(name)?.axis ?? this.axis).modes.value : [];
    return modes.length ? [...new Set(modes.map(unitIn))] : [usual];
  }

  /** Name of the mode beside a field: of the axis that has the field. */
  modeNameOf(name: string): string {
    const other = besideOf(name);
    return other ? `${other.axis}.mode` : "mode";
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

  /** Samples and column of a field, for what is shown from a time on. */
  placeOf(name: string, from_s: number): { layer: Layer; column: number } {
    const other = besideOf(name);
    const { layer, columnOf } = this.sourceOf(other?.axis ?? this.axis, from_s);
    return { layer, column: columnOf(other?.field ?? name) };
  }

  /** Samples of an axis for what is shown from a time on, and where its fields stand in them. */
  sourceOf(axis: string, from_s: number): { layer: Layer; columnOf: (field: string) => number } {
    const feed = feedOf(axis);
    const held = this.paused.peek() && (axis === this.axis ? this.paused.peek() : this.othersPaused.get(axis));
    return { layer: layerOver(held || feed.layers, from_s), columnOf: (field) => feed.column(field) };
  }

  /** Name of a field in words: with its axis, where others are beside it. */
  labelOf(name: string): string {
    return this.others.value.length && !besideOf(name) ? `${this.axis}.${name}` : name;
  }

  /** Value of a field at a time; NaN where it had another unit then than this, if one is given. */
  valueAt(name: string, at_s: number, unit?: string): number {
    if (unit !== undefined && this.unitAt(name, at_s, unit) !== unit) return NaN;
    const { layer, column } = this.placeOf(name, at_s);
    return column ? layer.ring.nearest(column, at_s) : NaN;
  }

  /** Value at a cursor. A cursor of before the page was loaded may be where there are no samples: NaN. */
  valueAtCursor(name: string, at_s: number): number {
    const { ring } = layerOver(this.layers, at_s);
    const isThere = ring.total > 0 && at_s >= ring.first_s && at_s <= ring.last_s;
    return isThere || this.areCursorsSet ? this.valueAt(name, at_s) : NaN;
  }

  /** Unit that a field had at a time. */
  unitAt(name: string, at_s: number, usual: string): string {
    const { layer, column } = this.placeOf(this.modeNameOf(name), at_s);
    const mode = column && this.isByMode(name) ? layer.ring.nearest(column, at_s) : NaN;
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
    const axes = new Set(this.others.peek().flatMap((name) => besideOf(name)?.axis ?? []));
    this.othersPaused = new Map([...axes].map((axis) => [axis, copy(feedOf(axis).layers)]));
    this.paused.value = copy(this.feed.layers);
    this.changes++;
  }

  /** Hold a picture of a window, from samples by axis, before those that the page has. */
  hold(from_s: number, to_s: number, found: ReadonlyMap<string, Layer>): void {
    this.live();
    this.pause();
    const over = (axis: string, layers: Layer[]) => [...(found.has(axis) ? [found.get(axis)!] : []), ...layers];
    this.othersPaused = new Map([...this.othersPaused].map(([axis, layers]) => [axis, over(axis, layers)]));
    this.paused.value = over(this.axis, this.paused.peek()!);
    [this.from_s.value, this.to_s.value] = [from_s, to_s];
    this.changes++;
  }

  live(): void {
    this.paused.value = null;
    this.triggered_s.value = null;
    this.othersPaused.clear();
    this.changes++;
  }

  show(from_s: number, to_s: number): void {
    if (!(to_s - from_s > 1e-4)) return;
    this.pause();
    const [first_s, last_s] = this.reach();
    const within = windowWithin(from_s, to_s, Math.min(this.from_s.peek(), first_s), Math.max(this.to_s.peek(), last_s));
    [this.from_s.value, this.to_s.value] = within;
    this.changes++;
  }

  /** First and last time of all samples that the page has about what is shown. */
  private reach(): [number, number] {
    const rings = this.layers.map(({ ring }) => ring).filter((ring) => ring.total > 0);
    return [Math.min(...rings.map((ring) => ring.first_s)), Math.max(...rings.map((ring) => ring.last_s))];
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

  /** Move what is shown by a part of its length: beyond what the page has by looking back, where there is a recording. */
  pan(part: number): void {
    const now_ms = performance.now();
    const [from_s, to_s] = [this.left_s(now_ms), this.right_s(now_ms)];
    const by_s = (to_s - from_s) * part;
    if (!by_s) return;
    if (pastAt.peek() !== null && !this.paused.peek()) return lookAt(to_s + by_s);
    if (!this.paused.peek() && part > 0) return; // it is at the newest already
    this.pause();
    const [first_s, last_s] = this.reach();
    const isOutside = from_s + by_s < first_s || (pastAt.peek() !== null && to_s + by_s > last_s);
    if (isOutside && end_s.peek() > 0 && first_s > 0) this.lookBack(to_s + by_s, to_s - from_s);
    else this.show(from_s + by_s, to_s + by_s);
  }

  /** Show a time of the run in all plots, and so much before it in this one. */
  private lookBack(at_s: number, length_s: number): void {
    this.live();
    const off = (window_s: number) => Math.abs(Math.log(window_s / length_s));
    this.window_s.value = WINDOWS_s.reduce((best, each) => (off(each) < off(best) ? each : best));
    lookAt(at_s);
  }

  /** Show the present, in all plots. */
  toPresent(): void {
    this.live();
    live();
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
    this.fixAll(new Map(range ? [...others, [pane, range] as const] : others));
  }

  fixAll(ranges: ReadonlyMap<string, readonly [number, number]>): void {
    this.fixed.value = ranges;
    this.changes++;
  }

  /** Draw a field of another axis, too, or no longer. */
  toggleOther(name: string): void {
    this.others.value = toggled(this.others.peek(), name);
  }

  toggleField(name: string): void {
    this.chosen.value = toggled(this.chosen.peek(), name);
  }

  /** Draw a field at the right axis of a pane, or in the pane of its unit for "". */
  moveRight(name: string, pane: string): void {
    const { [name]: _, ...others } = this.right.peek();
    this.right.value = pane ? { ...others, [name]: pane } : others;
  }

  /** Addresses of all that is drawn. */
  get signals(): string[] {
    return [...this.chosen.value.map((name) => this.addressOf(name)), ...this.others.value];
  }

  addressOf(name: string): string {
    return besideOf(name) ? name : `${this.axis}.${name}`;
  }

  /** Draw what these addresses name. */
  setSignals(signals: readonly string[]): void {
    const own = signals.flatMap((address) => (besideOf(address)?.axis === this.axis ? [besideOf(address)!.field] : []));
    this.chosen.value = own;
    this.others.value = signals.filter((address) => besideOf(address)?.axis !== this.axis);
  }
}

function toggled(names: readonly string[], name: string): string[] {
  return names.includes(name) ? names.filter((each) => each !== name) : [...names, name];
}

const MOST_OTHERS = 40;

function readOthers(raw: unknown): string[] | undefined {
  if (!Array.isArray(raw)) return undefined;
  return raw.filter((each): each is string => typeof each === "string" && besideOf(each) !== null).slice(0, MOST_OTHERS);
}

export function readXy(raw: unknown): XyChoice | null | undefined {
  const { x, y, isEqual } = (raw ?? {}) as Partial<XyChoice>;
  if (raw === null) return null;
  return typeof x === "string" && typeof y === "string" ? { x, y, isEqual: isEqual === true } : undefined;
}

export function readRight(raw: unknown): Record<string, string> | undefined {
  if (typeof raw !== "object" || raw === null || Array.isArray(raw)) return undefined;
  return Object.fromEntries(Object.entries(raw).filter((each): each is [string, string] => typeof each[1] === "string"));
}

export function readFixed(raw: unknown): Map<string, readonly [number, number]> {
  const ranges = typeof raw === "object" && raw !== null ? Object.entries(raw) : [];
  return new Map(ranges.filter((each): each is [string, [number, number]] => isRange(each[1])));
}

function isRange(raw: unknown): boolean {
  return Array.isArray(raw) && raw.length === 2 && raw.every(Number.isFinite) && raw[0] < raw[1];
}

const models = new Map<string, PlotModel>();

/** The model of a device's plots, or of those with another `id` whose times are those of the device. */
export function plotModelOf(device: DeviceRow, id = device.name): PlotModel {
  const key = `${keptFor.peek()}/${id}`;
  let model = models.get(key);
  if (model?.axis !== device.name || model.device.profile !== device.profile) models.set(key, (model = new PlotModel(device, id)));
  model.device = device;
  return model;
}
