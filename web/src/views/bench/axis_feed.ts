/** Samples of the axes, shared by all that show one. Of each the smallest and the largest value of intervals come, however
 * fast it swings, and are kept for minutes; where plots are in sight also many more, which are kept for seconds. What was
 * kept stays when nobody looks, and while the connection is lost. */

import { computed, effect, signal } from "@preact/signals";
import { Ring } from "../../model/ring";
import type { Layer, Sampling } from "../../model/sampling";
import type { Refused } from "../../net/protocol";
import { pastAt } from "../../past";
import { status } from "../../store";
import { SampleStream, type SampleRate } from "./sample_stream";

/** 600 looks a second, of all axes; five minutes. */
const COARSE: SampleRate = { rate_Hz: 60, points: 10, kept_s: 300 };
/** 7000 looks a second, about each control step, of the axis in sight. */
const FINE: SampleRate = { rate_Hz: 1000, points: 7, kept_s: 32 };
export const LOOKS_HZ = COARSE.rate_Hz * COARSE.points;
/** Samples come for so long when nobody looks any more: who goes to another view and comes back misses nothing. */
const KEPT_MS = 30_000;
/** A jump of the clocks by more is taken at once, less is followed slowly. */
const JUMP_s = 0.25;
const FOLLOW = 0.05;
/** Samples come 30 times a second, extremes for cards 10 times: so far behind the newest of them the edge of a live plot
 * moves evenly. */
const BATCH_s = 0.04;
const CARD_BATCH_s = 0.12;

const PAST_WINDOW_s = 10;
/** Hears rows as they come, of the finest samples: of each the time, and a column for each field of the feed. */
export type RowsEar = (values: Float64Array, rows: number, columns: number) => void;

/** Grows when others look, or at other fields. */
export const wantsChanged = signal(0);

export class AxisFeed {
  /** Names of the ring's columns, from 1 on. */
  fields: string[] = [];
  private readonly coarse: SampleStream;
  private fine: SampleStream | null = null;
  /** Samples around the time of the past that is shown; `past_samples.ts` puts them here. */
  past: Layer | null = null;
  /** Length of what plots show of the past. */
  pastWindow_s = PAST_WINDOW_s;
  /** Samples that were lost for lack of room. */
  readonly lost = signal(0);
  /** Modes of the axis's loop that its samples have, where they are watched. */
  readonly modes = signal<readonly number[]>([]);
  /** Why the bench does not give samples; empty: it does. */
  readonly refusal = signal("");

  private readonly wanted = new Map<symbol, { fields: string[]; isClose: boolean }>();
  private readonly ears = new Set<RowsEar>();
  private ending = 0;
  private offset_s = NaN;

  constructor(readonly axis: string) {
    this.coarse = this.stream(COARSE, (error) => (this.refusal.value = error.message));
  }

  private stream(rate: SampleRate, refused: (error: Refused) => void): SampleStream {
    const came: RowsEar = (values, rows, columns) => this.came(values, rows, columns, rate === FINE);
    return new SampleStream(this.axis, rate, { came, refused }, this.fields.length + 1);
  }

  /** Want fields from now on, all that can be had where somebody looks closely; answers the function that ends it. */
  want(fields: string[], isClose = false): () => void {
    const key = Symbol();
    this.wanted.set(key, { fields, isClose });
    wantsChanged.value += 1;
    this.begin();
    return () => {
      this.wanted.delete(key);
      window.clearTimeout(this.ending);
      this.ending = window.setTimeout(() => this.endUnwanted(), KEPT_MS);
    };
  }

  private get isCloselyWanted(): boolean {
    return [...this.wanted.values()].some(({ isClose }) => isClose);
  }

  private endUnwanted(): void {
    if (!this.wanted.size) this.coarse.end();
    if (this.isCloselyWanted) return;
    this.fine?.end();
    this.fine = null; // it is large
  }

  /** Begin all watches anew, as for another pace of the bench. */
  beginAgain(): void {
    const { speed } = this;
    for (const stream of [this.coarse, this.fine]) if (stream?.isOpen) stream.begin(this.fields, speed);
  }

  private get speed(): number {
    return status.peek().speed ?? 1;
  }

  /** Samples that are shown, the finest first: of the present, or of the time that the page looks back at. */
  get layers(): Layer[] {
    if (pastAt.peek() !== null) return [(this.past ??= { ring: new Ring(2, this.fields.length + 1), sampling: this.coarse.sampling })];
    return this.fine ? [this.fine, this.coarse] : [this.coarse];
  }

  /** The finest samples that come. */
  get finest(): Layer {
    return this.fine?.isOpen ? this.fine : this.coarse;
  }

  /** Extremes of the last minutes, or samples of the time that the page looks back at. */
  get ring(): Ring {
    return this.layers[this.layers.length - 1]!.ring;
  }

  get sampling(): Sampling {
    return this.layers[this.layers.length - 1]!.sampling;
  }

  /** Show so much of the past. */
  lookBackOver(window_s: number): void {
    if (window_s === this.pastWindow_s) return;
    this.pastWindow_s = window_s;
    wantsChanged.value += 1;
  }

  /** Whether somebody looks at it. */
  get isWanted(): boolean {
    return this.wanted.size > 0;
  }

  column(field: string): number {
    return this.fields.indexOf(field) + 1;
  }

  /** Time of the right edge of a live plot: it goes on evenly between the samples, and stands when they stop. */
  edge_s(now_ms: number): number {
    const past_s = pastAt.peek();
    if (past_s !== null) return past_s;
    const even = (now_ms / 1000) * this.speed + this.offset_s;
    return Math.min(even - (this.fine?.isOpen ? BATCH_s : CARD_BATCH_s) * this.speed, this.last_s);
  }

  private get last_s(): number {
    const { last_s } = this.coarse.ring;
    return this.fine?.ring.total ? Math.max(this.fine.ring.last_s, last_s || -Infinity) : last_s;
  }

  private begin(): void {
    const all = [...new Set([...this.wanted.values()].flatMap(({ fields }) => fields))];
    const missing = all.filter((field) => !this.fields.includes(field));
    if (missing.length) {
      this.fields = [...this.fields, ...missing];
      const columns = [0, ...this.fields.map((field) => (missing.includes(field) ? -1 : this.fields.indexOf(field) + 1))];
      for (const stream of [this.coarse, this.fine]) if (stream) stream.ring = stream.ring.rearranged(columns);
      this.past = null;
      wantsChanged.value += 1;
    }
    if (!this.fine && this.isCloselyWanted) this.fine = this.stream(FINE, () => undefined); // the extremes are there
    if (!this.coarse.isOpen) this.refusal.value = "";
    for (const stream of [this.coarse, this.fine]) {
      if (stream && (missing.length || !stream.isOpen)) stream.begin(this.fields, this.speed);
    }
  }

  /** Hear rows from now on; answers the function that ends it. */
  hear(ear: RowsEar): () => void {
    this.ears.add(ear);
    return () => void this.ears.delete(ear);
  }

  private came(values: Float64Array, rows: number, columns: number, isFine: boolean): void {
    if (isFine || !this.fine?.isOpen) for (const ear of this.ears) ear(values, rows, columns);
    this.noteModes(values, rows, columns);
    const lost = this.coarse.lost + (this.fine?.lost ?? 0);
    if (lost !== this.lost.peek()) this.lost.value = lost;
    const { speed } = this;
    const offset_s = this.last_s - (performance.now() / 1000) * speed;
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

/** Feeds that somebody looks at. */
export function wantedFeeds(): AxisFeed[] {
  return [...feeds.values()].filter((feed) => feed.isWanted);
}

const feeds = new Map<string, AxisFeed>();

export function feedOf(axis: string): AxisFeed {
  let feed = feeds.get(axis);
  if (!feed) feeds.set(axis, (feed = new AxisFeed(axis)));
  return feed;
}

const pace = computed(() => status.value.speed ?? 1);

effect(() => {
  void pace.value;
  for (const feed of feeds.values()) feed.beginAgain();
});
