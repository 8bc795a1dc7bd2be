/** How far places are from a path, in the path's order: as `hil.toolpath.deviation` has it. Pure. */

const BEHIND = 2;
const AHEAD = 4;

export class PathDeviation {
  /** Largest distance so far. */
  largest = 0;
  private readonly lengths: Float64Array;
  private at = 0;
  private within = 0;
  private readonly before: Float64Array;
  private isBegun = false;
  /** Piece up to which the first place is looked for. */
  private until = 0;

  /** `places`: points of the path, `axes` numbers each. The first place is looked for from point `from` to point
   * `to`, or near the beginning. */
  constructor(
    private readonly places: Float64Array,
    private readonly axes: number,
    from = 0,
    to = 0,
  ) {
    const count = Math.max(Math.floor(places.length / axes) - 1, 0);
    this.lengths = new Float64Array(count);
    this.before = new Float64Array(axes);
    for (let number = 0; number < count; number++) {
      let square = 0;
      for (let axis = 0; axis < axes; axis++) {
        const way = places[(number + 1) * axes + axis]! - places[number * axes + axis]!;
        square += way * way;
      }
      this.lengths[number] = Math.sqrt(square);
    }
    this.at = Math.min(from, Math.max(count - 1, 0));
    this.until = Math.min(to, count);
  }

  /** Distance of the next place from the path. */
  take(place: ArrayLike<number>): number {
    let moved = 0;
    for (let axis = 0; axis < this.axes; axis++) {
      if (this.isBegun) moved += (place[axis]! - this.before[axis]!) ** 2;
      this.before[axis] = place[axis]!;
    }
    this.isBegun = true;
    let ahead = AHEAD + 2 * Math.sqrt(moved);
    for (; this.until > this.at; this.until--) ahead += this.lengths[this.until - 1] ?? 0;
    const off = this.nearest(place, ahead);
    this.largest = Math.max(this.largest, off);
    return off;
  }

  private nearest(place: ArrayLike<number>, ahead: number): number {
    if (!this.lengths.length) return 0;
    let first = this.at;
    for (let back = BEHIND - this.within; first > 0 && back > 0; ) back -= this.lengths[--first]!;
    let best = Infinity;
    let [bestAt, bestWithin] = [this.at, this.within];
    let left = ahead + this.within;
    for (let number = first; number < this.lengths.length && (number <= this.at || left > 0); number++) {
      const [part, off] = this.toPiece(number, place);
      if (off <= best + 1e-9) [best, bestAt, bestWithin] = [off, number, part * this.lengths[number]!];
      if (number >= this.at) left -= this.lengths[number]!;
    }
    [this.at, this.within] = [bestAt, bestWithin];
    return best;
  }

  /** Part of a straight piece at which it is nearest to a place, and the distance. */
  private toPiece(number: number, place: ArrayLike<number>): [number, number] {
    const { places, axes } = this;
    const begin = number * axes;
    let square = 0;
    let dot = 0;
    for (let axis = 0; axis < axes; axis++) {
      const a = places[begin + axis]!;
      const way = places[begin + axes + axis]! - a;
      square += way * way;
      dot += way * (place[axis]! - a);
    }
    const part = square > 0 ? Math.min(Math.max(dot / square, 0), 1) : 0;
    let off = 0;
    for (let axis = 0; axis < axes; axis++) {
      const a = places[begin + axis]!;
      off += (a + part * (places[begin + axes + axis]! - a) - place[axis]!) ** 2;
    }
    return [part, Math.sqrt(off)];
  }
}
