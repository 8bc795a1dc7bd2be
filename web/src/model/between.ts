/** Figures of a signal between two times. Pure. */

import type { Ring } from "./ring";

export interface BetweenFigures {
  mean: number;
  rms: number;
  least: number;
  most: number;
  /** Change from the first row to the last, by the second. */
  slope: number;
}

const NOTHING: BetweenFigures = { mean: NaN, rms: NaN, least: NaN, most: NaN, slope: NaN };

/** Find the figures of a column between two times, in any order. The signal is a straight line from row to row, so extremes
 * of intervals count with what lies between them; where rows have no values there is none. */
export function between(ring: Ring, column: number, a_s: number, b_s: number): BetweenFigures {
  const [from_s, to_s] = a_s < b_s ? [a_s, b_s] : [b_s, a_s];
  if (column < 1 || column >= ring.width || !(to_s > from_s)) return NOTHING;
  let [least, most, area, square, covered_s] = [Infinity, -Infinity, 0, 0, 0];
  let [first, first_s, last, last_s, end_s] = [NaN, NaN, NaN, NaN, NaN];
  for (let index = ring.indexAt(from_s); index < ring.total; index++) {
    const at_s = ring.at(0, index);
    if (at_s > to_s) break;
    const value = ring.at(column, index);
    if (value !== value) {
      last_s = NaN;
      continue;
    }
    if (value < least) least = value;
    if (value > most) most = value;
    if (first !== first) [first, first_s] = [value, at_s];
    const by_s = at_s - last_s;
    if (by_s > 0) {
      area += (by_s * (last + value)) / 2;
      square += (by_s * (last * last + last * value + value * value)) / 3;
      covered_s += by_s;
    }
    [last, last_s, end_s] = [value, at_s, at_s];
  }
  if (!(covered_s > 0)) return least <= most ? { mean: least, rms: Math.abs(least), least, most, slope: NaN } : NOTHING;
  const slope = (last - first) / (end_s - first_s);
  return { mean: area / covered_s, rms: Math.sqrt(square / covered_s), least, most, slope };
}
