/** How samples were made: each at its moment, or two of each interval with the smallest and the largest value. Pure. */

import type { Ring } from "./ring";

export interface Sampling {
  /** Simulated time between samples, or of an interval. */
  interval_s: number;
  isExtremes: boolean;
}

/** Say it beside a plot: "1000/s", "min/max of 16.7 ms". */
export function samplingText({ interval_s, isExtremes }: Sampling): string {
  if (!isExtremes) return `${rounded(1 / interval_s)}/s`;
  const isLong = interval_s >= 1;
  return `min/max of ${rounded(isLong ? interval_s : interval_s * 1000)} ${isLong ? "s" : "ms"}`;
}

function rounded(value: number): string {
  return String(Number(value.toPrecision(3)));
}

/** Samples of an axis at one rate. */
export interface Layer {
  ring: Ring;
  sampling: Sampling;
}

/** Time by which rings of the same watch may begin apart. */
const SAME_s = 0.1;

/** Choose the layer for what is shown from a time on: of those that reach back to it the finest, else the one that reaches
 * back furthest. `layers`: the finest first, at least one. */
export function layerOver(layers: readonly Layer[], from_s: number): Layer {
  const whole = layers.find(({ ring }) => ring.total > 0 && ring.first_s <= from_s);
  if (whole) return whole;
  return layers.reduce((best, each) => (!best.ring.total || each.ring.first_s < best.ring.first_s - SAME_s ? each : best));
}
