/** Ring of samples: rows of a time and values, columns apart, in typed arrays. Pure; nothing is allocated by `push`. */

/** Where the time goes back (the bench began anew), this much is left between the old rows and the new. */
export const RESTART_GAP_s = 1;

export class Ring {
  /** Columns; 0 is the time in seconds, ascending. Row `index` is at `index % capacity`. */
  readonly columns: Float64Array[];
  /** Rows that ever came; the newest has the index `total - 1`. */
  total = 0;
  /** Seconds by which rows have been moved back, over all restarts of the bench's clock. */
  movedBack_s = 0;
  private isRestarted = false;

  constructor(
    readonly capacity: number,
    readonly width: number,
  ) {
    this.columns = Array.from({ length: width }, () => new Float64Array(capacity));
  }

  get length(): number {
    return Math.min(this.total, this.capacity);
  }

  /** Index of the oldest row that is still there. */
  get first(): number {
    return this.total - this.length;
  }

  at(column: number, index: number): number {
    return this.columns[column]![index % this.capacity]!;
  }

  /** Time of the oldest row. */
  get first_s(): number {
    return this.total ? this.at(0, this.first) : NaN;
  }

  get last_s(): number {
    return this.total ? this.at(0, this.total - 1) : NaN;
  }

  /** Append rows, one after another in `values`; further columns of `values` than the ring's are left out. */
  push(values: Float64Array, rows: number, columns: number): void {
    const width = Math.min(columns, this.width);
    for (let row = 0; row < rows; row++) {
      const from = row * columns;
      const time = values[from]!;
      if (this.total && (this.isRestarted || time < this.last_s)) this.moveBack(this.last_s - time + RESTART_GAP_s);
      this.isRestarted = false;
      const to = this.total % this.capacity;
      for (let column = 0; column < width; column++) this.columns[column]![to] = values[from + column]!;
      for (let column = width; column < this.width; column++) this.columns[column]![to] = NaN;
      this.total++;
    }
  }

  /** Append a row without values, so that no line is drawn across what is missing. */
  gap(): void {
    if (!this.total) return;
    const time = this.last_s;
    const to = this.total % this.capacity;
    this.columns[0]![to] = time;
    for (let column = 1; column < this.width; column++) this.columns[column]![to] = NaN;
    this.total++;
  }

  /** The bench begins anew: what comes next is of another clock, whatever it shows. */
  restart(): void {
    this.isRestarted = true;
  }

  private moveBack(by_s: number): void {
    const times = this.columns[0]!;
    for (let at = 0; at < this.capacity; at++) times[at]! -= by_s;
    this.movedBack_s += by_s;
    this.gap();
  }

  /** Find the first index whose time is at least `time_s`; `total` if there is none. */
  indexAt(time_s: number): number {
    let low = this.first;
    let high = this.total;
    while (low < high) {
      const middle = (low + high) >>> 1;
      if (this.at(0, middle) < time_s) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** Value of a column at a time, of the nearest row; NaN where there are no rows, or no such column. */
  nearest(column: number, time_s: number): number {
    if (!this.total || column >= this.width) return NaN;
    let index = Math.min(this.indexAt(time_s), this.total - 1);
    if (index > this.first && time_s - this.at(0, index - 1) < this.at(0, index) - time_s) index--;
    return this.at(column, index);
  }

  /** Copy the ring as it is now: a pause looks at the copy. */
  copy(): Ring {
    const copied = new Ring(this.capacity, this.width);
    copied.total = this.total;
    copied.movedBack_s = this.movedBack_s;
    for (const [at, column] of this.columns.entries()) copied.columns[at]!.set(column);
    return copied;
  }

  /** Copy with other columns: column `to` takes that of `from[to]`, or is without values for -1. */
  rearranged(from: number[]): Ring {
    const copied = new Ring(this.capacity, from.length);
    copied.total = this.total;
    copied.movedBack_s = this.movedBack_s;
    from.forEach((source, at) => {
      if (source < 0) copied.columns[at]!.fill(NaN);
      else copied.columns[at]!.set(this.columns[source]!);
    });
    return copied;
  }
}
