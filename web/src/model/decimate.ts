/** Rows of a window as at most so many points, in arrays of a fixed length: what a plot draws. Pure. */

import type { Ring } from "./ring";

const SAME_MOMENT_s = 1e-9;

/** Make the arrays for `decimate`: one for each column. */
export function display(ring: Ring, points: number): Float64Array[] {
  return Array.from({ length: ring.width }, () => new Float64Array(points));
}

/** Fill `out` with the rows of `ring` from `from_s` to `to_s`, with one more on each side.
 *
 * More rows than points: buckets of 2^n rows are drawn as their minimum and maximum. Buckets begin at multiples
 * of their size, so that they do not change while the window moves. What is left of `out` repeats the last
 * point. Answers the number of points that were made.
 */
export function decimate(ring: Ring, from_s: number, to_s: number, out: Float64Array[]): number {
  const points = out[0]!.length;
  const first = Math.max(ring.indexAt(from_s) - 1, ring.first);
  const end = Math.min(ring.indexAt(to_s) + 1, ring.total);
  let size = 1;
  while (size === 1 ? end - first > points : 2 * ((end - first) / size + 2) > points) size *= 2;
  const made = size === 1 ? copyRows(ring, first, end, out) : bucketRows(ring, first, end, size, out);
  for (const column of out) column.fill(made ? column[made - 1]! : NaN, made);
  return made;
}

function copyRows(ring: Ring, first: number, end: number, out: Float64Array[]): number {
  for (let column = 0; column < ring.width; column++) {
    const to = out[column]!;
    for (let index = first; index < end; index++) to[index - first] = ring.at(column, index);
  }
  return Math.max(end - first, 0);
}

function bucketRows(ring: Ring, first: number, end: number, size: number, out: Float64Array[]): number {
  let made = 0;
  for (let begin = first - (first % size); begin < end; begin += size) {
    const low = Math.max(begin, ring.first);
    const high = Math.min(begin + size, ring.total);
    out[0]![made] = ring.at(0, low);
    out[0]![made + 1] = ring.at(0, (low + high - 1) >> 1);
    for (let column = 1; column < ring.width; column++) extremes(ring, column, low, high, out[column]!, made);
    made += 2;
  }
  return made;
}

/** Fill `out` with a column of another ring beside rows that were made at `times`, of which `made` count: of each two of them
 * the extremes of what lies from the first of them to the next two; where nothing does, what was before. */
export function beside(ring: Ring, column: number, times: Float64Array, made: number, out: Float64Array): void {
  for (let at = 0; at < made; at += 2) {
    const end_s = at + 2 < made ? times[at + 2]! : times[made - 1]! + SAME_MOMENT_s;
    const high = ring.indexAt(end_s);
    const low = Math.min(ring.indexAt(times[at]!), high - 1);
    if (column < 1 || column >= ring.width || low < ring.first) out[at] = out[at + 1] = NaN;
    else extremes(ring, column, low, high, out, at);
  }
  out.fill(made ? out[made - 1]! : NaN, made);
}

/** Put minimum and maximum of rows in the order in which they came; a row without values makes both NaN, which is
 * a gap in the line. */
function extremes(ring: Ring, column: number, low: number, high: number, out: Float64Array, to: number): void {
  const values = ring.columns[column]!;
  let least = Infinity;
  let most = -Infinity;
  let isMostFirst = false;
  let place = low % ring.capacity;
  for (let index = low; index < high; index++) {
    const value = values[place]!;
    if (++place === ring.capacity) place = 0;
    if (value !== value) {
      least = most = NaN;
      break;
    }
    if (value < least) {
      least = value;
      isMostFirst = true;
    }
    if (value > most) {
      most = value;
      isMostFirst = false;
    }
  }
  out[to] = isMostFirst ? most : least;
  out[to + 1] = isMostFirst ? least : most;
}

/** Copy values to `out` where those of another column beside them pass; NaN elsewhere. Extremes are two beside one another,
 * and either may be the first: the one before and the one behind count, too. */
export function copyWhere(values: ArrayLike<number>, others: ArrayLike<number>, passes: (other: number) => boolean, out: Float64Array): void {
  let isBefore = true;
  let isHere = passes(others[0]!);
  for (let at = 0; at < out.length; at++) {
    const isBehind = at + 1 === out.length || passes(others[at + 1]!);
    out[at] = isBefore && isHere && isBehind ? values[at]! : NaN;
    isBefore = isHere;
    isHere = isBehind;
  }
}

/** Put the least and the most of the first `made` values into `out`, widening what it has; NaN do not count. */
export function widen(values: ArrayLike<number>, made: number, out: [number, number]): void {
  for (let at = 0; at < made; at++) {
    const value = values[at]!;
    if (value < out[0]) out[0] = value;
    if (value > out[1]) out[1] = value;
  }
}

/** Move a window into what there is, from `first_s` to `last_s`; one that is longer becomes all of it. */
export function windowWithin(from_s: number, to_s: number, first_s: number, last_s: number): [number, number] {
  const length_s = Math.min(to_s - from_s, last_s - first_s);
  const moved_s = Math.min(Math.max(from_s, first_s), last_s - length_s);
  return [moved_s, moved_s + length_s];
}

const NICE = [1, 2, 2.5, 5, 10];

/** Smallest of 1, 2, 2.5 and 5 times a power of ten that is at least `value`. */
export function niceStep(value: number): number {
  if (!(value > 0) || !Number.isFinite(value)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  for (const nice of NICE) if (nice * power >= value * (1 - 1e-9)) return nice * power;
  return 10 * power;
}

/** Put the range of an axis for values from `low` to `high` into `out`: whole steps, with room, never empty. */
export function niceRange(low: number, high: number, leastSpan: number, out: [number, number]): [number, number] {
  if (!Number.isFinite(low) || !Number.isFinite(high)) {
    out[0] = -leastSpan / 2;
    out[1] = leastSpan / 2;
    return out;
  }
  const span = Math.max((high - low) * 1.1, leastSpan);
  const middle = (low + high) / 2;
  const step = niceStep(span / 8);
  out[0] = Math.floor((middle - span / 2) / step) * step;
  out[1] = Math.ceil((middle + span / 2) / step) * step;
  return out;
}
