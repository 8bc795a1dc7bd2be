/** One signal over another: points of both at the same times. Pure. */

import { niceRange } from "./decimate";
import type { Ring } from "./ring";

/** Where a signal is: a column of a ring. `isExtremes`: two rows of each interval have its smallest and its largest value. */
export interface XySource {
  ring: Ring;
  column: number;
  isExtremes: boolean;
}

/** Points, in arrays of a fixed length. */
export interface XyPoints {
  at_s: Float64Array;
  x: Float64Array;
  y: Float64Array;
  count: number;
}

export function xyRoom(most: number): XyPoints {
  return { at_s: new Float64Array(most), x: new Float64Array(most), y: new Float64Array(most), count: 0 };
}

/** Fill `out` with the newest points between two times; answers the time from which on there are some. The extremes of an
 * interval are of other moments in each signal: the middle of both counts. */
export function xyPoints(x: XySource, y: XySource, from_s: number, to_s: number, out: XyPoints): number {
  out.count = 0;
  if (x.column < 1 || x.column >= x.ring.width || y.column < 1 || y.column >= y.ring.width) return to_s;
  const step = x.isExtremes ? 2 : 1;
  const end = x.ring.indexAt(to_s) - (step - 1);
  const first = Math.max(x.ring.indexAt(from_s), end - out.x.length * step);
  // Beginning at a multiple of the step the points stay the same while the window moves.
  for (let index = first + ((step - (first % step)) % step); index < end; index += step) {
    const at_s = x.isExtremes ? (x.ring.at(0, index) + x.ring.at(0, index + 1)) / 2 : x.ring.at(0, index);
    const place = out.count++;
    out.at_s[place] = at_s;
    out.x[place] = x.isExtremes ? middleOf(x, index) : x.ring.at(x.column, index);
    out.y[place] = y.ring === x.ring ? (y.isExtremes ? middleOf(y, index) : y.ring.at(y.column, index)) : valueAt(y, at_s);
  }
  return out.count ? out.at_s[0]! : to_s;
}

function middleOf({ ring, column }: XySource, index: number): number {
  return (ring.at(column, index) + ring.at(column, index + 1)) / 2;
}

/** Value of a signal at a time, on the straight line between its rows; NaN where there are none about it. */
export function valueAt(source: XySource, at_s: number): number {
  const { ring, column, isExtremes } = source;
  const behind = ring.indexAt(at_s);
  if (behind >= ring.total || behind <= ring.first) return NaN;
  if (isExtremes) return middleOf(source, behind - 1);
  const [before_s, behind_s] = [ring.at(0, behind - 1), ring.at(0, behind)];
  const part = behind_s > before_s ? (at_s - before_s) / (behind_s - before_s) : 1;
  return ring.at(column, behind - 1) * (1 - part) + ring.at(column, behind) * part;
}

export interface XyRanges {
  x: [number, number];
  y: [number, number];
}

/** Put the ranges of both axes that hold all points into `out`; `equal`: width and height of a picture in which a unit is
 * as long in both. */
export function xyRanges({ x, y, count }: XyPoints, least: readonly [number, number], equal: readonly [number, number] | null, out: XyRanges): void {
  spread(x, count, least[0], out.x);
  spread(y, count, least[1], out.y);
  if (!equal) return;
  const perPixel = Math.max((out.x[1] - out.x[0]) / equal[0], (out.y[1] - out.y[0]) / equal[1]);
  widenTo(out.x, perPixel * equal[0]);
  widenTo(out.y, perPixel * equal[1]);
}

function spread(values: Float64Array, count: number, least: number, out: [number, number]): void {
  let [low, high] = [Infinity, -Infinity];
  for (let at = 0; at < count; at++) {
    const value = values[at]!;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  niceRange(low, high, least, out);
}

function widenTo(range: [number, number], length: number): void {
  const middle = (range[0] + range[1]) / 2;
  range[0] = middle - length / 2;
  range[1] = middle + length / 2;
}

/** Time of the point that is nearest to a place, with distances in parts of the ranges; NaN: there is none. */
export function nearestTime({ at_s, x, y, count }: XyPoints, ranges: XyRanges, atX: number, atY: number): number {
  const [wide, high] = [ranges.x[1] - ranges.x[0], ranges.y[1] - ranges.y[0]];
  let [best, found] = [Infinity, NaN];
  for (let at = 0; at < count; at++) {
    const distance = ((x[at]! - atX) / wide) ** 2 + ((y[at]! - atY) / high) ** 2;
    if (distance < best) [best, found] = [distance, at_s[at]!];
  }
  return found;
}
