/** What is shown of one axis's plots: the time, a pause, cursors, chosen fields. It outlives the view. */

import { computed, signal } from "@preact/signals";
import type { Ring } from "../../model/ring";
import type { DeviceRow } from "../../model/door";
import { feedOf } from "./axis_feed";
import { isByMode, unitIn, usualFields } from "./axis_fields";

export const WINDOWS_s = [1, 2, 5, 10, 30, 60, 120, 300];

export class PlotModel {
  readonly window_s = signal(10);
  /** The samples as they were when the plot was paused; null: it is live. */
  readonly paused = signal<Ring | null>(null);
  /** Shown time while it is paused. */
  readonly from_s = signal(0);
  readonly to_s = signal(0);
  readonly cursorA = signal<number | null>(null);
  readonly cursorB = signal<number | null>(null);
  readonly chosen = signal<string[]>([]);
  readonly isPaused = computed(() => this.paused.value !== null);
  /** Grows when something has to be drawn again although no sample came. */
  changes = 0;

  constructor(
    readonly device: DeviceRow,
    readonly axis = device.name,
  ) {
    this.chosen.value = usualFields(device);
  }

  get feed() {
    return feedOf(this.axis);
  }

  get ring(): Ring {
    return this.paused.peek() ?? this.feed.ring;
  }

  /** Left edge of what is shown at a moment; the right one is `right_s`. */
  left_s(now_ms: number): number {
    return this.paused.peek() ? this.from_s.peek() : this.right_s(now_ms) - this.window_s.peek();
  }

  right_s(now_ms: number): number {
    return this.paused.peek() ? this.to_s.peek() : this.feed.edge_s(now_ms);
  }

  /** Value of a field at a time; NaN where it had another unit then than this, if one is given. */
  valueAt(name: string, at_s: number, unit?: string): number {
    const isOther = unit !== undefined && this.unitAt(name, at_s, unit) !== unit;
    return isOther ? NaN : this.ring.nearest(this.feed.column(name), at_s);
  }

  /** Unit that a field had at a time. */
  unitAt(name: string, at_s: number, usual: string): string {
    const column = this.feed.column("mode");
    const mode = column && isByMode(this.device, name) ? this.ring.nearest(column, at_s) : NaN;
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
    this.paused.value = this.feed.ring.copy();
    this.changes++;
  }

  live(): void {
    this.paused.value = null;
    this.changes++;
  }

  show(from_s: number, to_s: number): void {
    if (!(to_s - from_s > 1e-4)) return;
    this.pause();
    this.from_s.value = from_s;
    this.to_s.value = to_s;
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

  toggleField(name: string): void {
    const before = this.chosen.peek();
    this.chosen.value = before.includes(name) ? before.filter((field) => field !== name) : [...before, name];
  }
}

const models = new Map<string, PlotModel>();

export function plotModelOf(device: DeviceRow): PlotModel {
  let model = models.get(device.name);
  if (!model || model.device.profile !== device.profile) models.set(device.name, (model = new PlotModel(device)));
  return model;
}
