/** Places of a machine of its axes' samples. Pure. */

import type { DrawingAxis } from "./drawing";

const SAME_s = 1e-4;
/** Signals that tell where an axis stands by its board's zero, in which set-points are; `hil zero` moves the shaft's. */
const BOARD_ANGLES = ["yw", "commanded_deg", "to_be_deg"];

/** The board's angle among the fields of an axis; undefined: its board has no zero of its own. */
export function boardAngleOf(fields: readonly { name: string }[]): string | undefined {
  return BOARD_ANGLES.find((name) => fields.some((field) => field.name === name));
}

export class SampledPlaces {
  /** The last place that was made, and its time. */
  readonly place: Float64Array;
  at_s = NaN;
  /** Board's angle less the shaft's, by axis, as the first samples have them. */
  private readonly shifts_deg: (number | undefined)[] = [];
  private readonly waiting: Float64Array[][];

  constructor(private readonly axes: readonly Pick<DrawingAxis, "deg_per_unit" | "zero_deg">[]) {
    this.place = new Float64Array(axes.length);
    this.waiting = axes.map(() => []);
  }

  /** Take rows of an axis: time, shaft's angle and, if the board has a zero of its own, the board's. */
  take(axis: number, values: Float64Array, rows: number, columns: number): void {
    for (let row = 0; row < rows; row++) this.waiting[axis]!.push(values.slice(row * columns, (row + 1) * columns));
  }

  /** Make the next place of samples of one time; false: some are missing yet. */
  next(): boolean {
    while (this.waiting.every((rows) => rows.length > 0)) {
      const last_s = Math.max(...this.waiting.map((rows) => rows[0]![0]!));
      const late = this.waiting.find((rows) => rows[0]![0]! < last_s - SAME_s);
      if (late) {
        late.shift();
        continue;
      }
      this.at_s = last_s;
      this.waiting.forEach((rows, number) => {
        const { deg_per_unit, zero_deg } = this.axes[number]!;
        const [, shaft_deg, board_deg] = rows.shift()!;
        const shift_deg = (this.shifts_deg[number] ??= board_deg === undefined ? 0 : board_deg - shaft_deg!);
        this.place[number] = (shaft_deg! + shift_deg - zero_deg) / deg_per_unit;
      });
      return true;
    }
    return false;
  }
}
