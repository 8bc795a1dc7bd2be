/** Samples of the axes: one watch and one ring for each, shared by all that show it. The ring stays when nobody
 * looks, and while the connection is lost. */

import { signal } from "@preact/signals";
import { Ring } from "../../model/ring";
import type { WatchHandle } from "../../net/channels";
import { link, status } from "../../store";

export const RATE_HZ = 60;
/** Five minutes. */
const CAPACITY = RATE_HZ * 300;
/** Samples come for so long when nobody looks any more: who goes to another view and comes back misses nothing. */
const KEPT_MS = 30_000;
/** A jump of the clocks by more is taken at once, less is followed slowly. */
const JUMP_s = 0.25;
const FOLLOW = 0.05;

export class AxisFeed {
  /** Names of the ring's columns, from 1 on. */
  fields: string[] = [];
  ring = new Ring(CAPACITY, 1);
  /** Samples that the bench lost for lack of room. */
  readonly lost = signal(0);
  /** Modes of the axis's loop that its samples have, where they are watched. */
  readonly modes = signal<readonly number[]>([]);
  /** Why the bench does not give samples; empty: it does. */
  readonly refusal = signal("");

  private readonly wanted = new Map<symbol, string[]>();
  private watch: WatchHandle | null = null;
  private isGap = false;
  private ending = 0;
  /** The start of the bench that the newest samples are of. */
  private instance: string | undefined;
  private offset_s = NaN;

  constructor(readonly axis: string) {}

  /** Want fields from now on; answers the function that ends it. */
  want(fields: string[]): () => void {
    const key = Symbol();
    this.wanted.set(key, fields);
    this.begin();
    return () => {
      this.wanted.delete(key);
      window.clearTimeout(this.ending);
      this.ending = window.setTimeout(() => this.endUnwanted(), KEPT_MS);
    };
  }

  private endUnwanted(): void {
    if (this.wanted.size) return;
    this.watch?.close();
    this.watch = null;
    this.isGap = true;
  }

  column(field: string): number {
    return this.fields.indexOf(field) + 1;
  }

  /** Time of the right edge of a live plot: it goes on evenly between the samples, and stands when they stop. */
  edge_s(now_ms: number): number {
    const speed = status.peek().speed ?? 1;
    const even = (now_ms / 1000) * speed + this.offset_s;
    return Math.min(even, this.ring.last_s + 0.1 * speed);
  }

  private begin(): void {
    const all = [...new Set([...this.wanted.values()].flat())];
    const missing = all.filter((field) => !this.fields.includes(field));
    if (missing.length) {
      this.fields = [...this.fields, ...missing];
      const columns = [0, ...this.fields.map((field) => (missing.includes(field) ? -1 : this.fields.indexOf(field) + 1))];
      this.ring = this.ring.rearranged(columns);
    }
    if (this.watch && !missing.length && !this.refusal.peek()) return;
    this.watch?.close();
    this.refusal.value = "";
    this.watch = link.watch(
      { what: "samples", target: this.axis, fields: this.fields, rate_Hz: RATE_HZ },
      {
        samples: (values, rows, columns, lost) => this.take(values, rows, columns, lost),
        again: () => (this.isGap = true),
        refused: (error) => (this.refusal.value = error.message),
      },
    );
  }

  private take(values: Float64Array, rows: number, columns: number, lost: number): void {
    if (!rows) return;
    const instance = link.hello.peek()?.instance;
    if (instance !== this.instance) this.ring.restart();
    else if (this.isGap) this.ring.gap();
    this.instance = instance;
    this.isGap = false;
    this.ring.push(values, rows, columns);
    this.noteModes(values, rows, columns);
    if (lost !== this.lost.peek()) this.lost.value = lost;
    const speed = status.peek().speed ?? 1;
    const offset_s = this.ring.last_s - (performance.now() / 1000) * speed;
    const by_s = offset_s - this.offset_s;
    this.offset_s = Math.abs(by_s) < JUMP_s * speed ? this.offset_s + FOLLOW * by_s : offset_s;
  }

  private noteModes(values: Float64Array, rows: number, columns: number): void {
    const column = this.column("mode");
    if (!column) return;
    for (let row = 0; row < rows; row++) {
      const mode = values[row * columns + column]!;
      if (!this.modes.peek().includes(mode)) this.modes.value = [...this.modes.peek(), mode];
    }
  }
}

const feeds = new Map<string, AxisFeed>();

export function feedOf(axis: string): AxisFeed {
  let feed = feeds.get(axis);
  if (!feed) feeds.set(axis, (feed = new AxisFeed(axis)));
  return feed;
}
