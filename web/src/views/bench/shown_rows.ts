/** Rows of what is shown of an axis, made once for all of its panes. */

import { decimate, display } from "../../model/decimate";
import type { Layer } from "../../model/sampling";

/** A bucket of 2^n rows for about each pixel: 10 s of the finest samples are 625 of 32. */
const POINTS = 1280;

export class ShownRows {
  /** A column for each of the ring's; the first is the time. */
  data: Float64Array[] = [];
  /** Points that were made; what is left repeats the last. */
  made = 0;
  private ring: Layer["ring"] | null = null;
  private total = -1;
  private from_s = NaN;
  private to_s = NaN;

  /** Make the rows of a window, unless they are there. */
  of({ ring }: Layer, from_s: number, to_s: number): void {
    if (ring === this.ring && ring.total === this.total && from_s === this.from_s && to_s === this.to_s) return;
    if (ring.width !== this.data.length) this.data = display(ring, POINTS);
    [this.ring, this.total, this.from_s, this.to_s] = [ring, ring.total, from_s, to_s];
    this.made = decimate(ring, from_s, to_s, this.data);
  }
}
