/** Samples as a table of CSV. Pure. */

import type { Ring } from "./ring";
import { type Layer, samplingText } from "./sampling";

export interface CsvColumn {
  name: string;
  /** Units that its values have; none: it has no unit. */
  units: string[];
  /** In the ring. */
  column: number;
  /** Ring of another axis that has it: its nearest row counts. */
  of?: Ring;
}

/** Name a column as `hil export` does: with the unit, where the name does not end with it. */
function titleOf({ name, units }: CsvColumn): string {
  const named = units.filter(Boolean);
  return !named.length || (named.length === 1 && name.endsWith(`_${named[0]}`)) ? name : `${name} [${named.join(" or ")}]`;
}

/** Write rows of a window as CSV: at_s, the fields, and how each row was sampled. Rows of the run before, which stand
 * before 0, are left out: their clock was another. */
export function csvOf({ ring, sampling }: Layer, fields: CsvColumn[], from_s: number, to_s: number): string {
  const lines = [["at_s", ...fields.map(titleOf), "sampling"].join(",")];
  const how = samplingText(sampling);
  for (let index = ring.indexAt(Math.max(from_s, 0)); index < ring.total && ring.at(0, index) <= to_s; index++) {
    const values = fields.map(({ of, column }) => (of ? of.nearest(column, ring.at(0, index)) : ring.at(column, index)));
    if (values.every(Number.isNaN)) continue;
    lines.push([ring.at(0, index), ...values.map((value) => (Number.isNaN(value) ? "" : value)), how].join(","));
  }
  return `${lines.join("\n")}\n`;
}
