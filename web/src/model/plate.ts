/** Axes of an x-y plate, and where it is: by the machine of the bench's drawing, or by millimetres a turn. Pure. */

import type { DrawingAxis } from "./drawing";

export interface PlateAxis {
  name: string;
  deg_per_mm: number;
  zero_deg: number;
  /** Where it may be, in mm; null: nothing says so. */
  range_mm: readonly [number, number] | null;
}

/** Millimetres a turn where no machine says otherwise. */
export const MM_PER_TURN = 40;

/** Make an axis of the plate: of the machine's axis with this letter, or that which is chosen, else of a shaft. A scale that
 * is chosen comes before the machine's. */
export function plateAxis(letter: string, chosen: string, mm_per_turn: number | null, machine: readonly DrawingAxis[], shaft = ""): PlateAxis {
  const found = machine.find((each) => each.unit === "mm" && (chosen ? each.axis === chosen : each.letter === letter && each.axis !== ""));
  const name = found?.axis ?? (chosen || shaft);
  if (!found || mm_per_turn !== null) return { name, deg_per_mm: 360 / (mm_per_turn ?? MM_PER_TURN), zero_deg: 0, range_mm: null };
  return { name, deg_per_mm: found.deg_per_unit, zero_deg: found.zero_deg, range_mm: found.range };
}

export function placeOf({ deg_per_mm, zero_deg }: PlateAxis, at_deg: number): number {
  return (at_deg - zero_deg) / deg_per_mm;
}
