/** Two step responses beside each other: what they differ by, and as a table of CSV. Pure. */

import type { StepFigures, StepRows } from "./step_response";

interface Response {
  rows: StepRows;
  figures: StepFigures;
  gains: Readonly<Record<string, number>>;
}

export interface Difference {
  rise_ms: number;
  overshoot: number;
  settling_ms: number;
  error_deg: number;
  gains: { name: string; was: number; is: number }[];
}

/** Digits of a gain that a person wrote: the board has it in 32 bits. */
const DIGITS = 6;

export function differenceOf(before: Response, after: Response): Difference {
  const by = (name: keyof StepFigures) => after.figures[name] - before.figures[name];
  const gains = Object.entries(after.gains).map(([name, is]) => ({ name, was: rounded(before.gains[name] ?? NaN), is: rounded(is) }));
  return {
    rise_ms: by("rise_s") * 1000,
    overshoot: by("overshoot_percent"),
    settling_ms: by("settling_s") * 1000,
    error_deg: by("final_error"),
    gains: gains.filter(({ was, is }) => was !== is && !Number.isNaN(is)),
  };
}

function rounded(value: number): number {
  return Number(value.toPrecision(DIGITS));
}

/** All samples of the responses that there are, the one after the other. */
export function responsesCsv(responses: { before: Response | null; after: Response | null }): string {
  const lines = ["response,at_s,set_point_deg,position_deg"];
  for (const name of ["before", "after"] as const) {
    const rows = responses[name]?.rows;
    if (!rows) continue;
    for (const [row, at_s] of rows.times_s.entries()) lines.push(`${name},${Number(at_s.toFixed(9))},${rows.setpoint[row]},${rows.position[row]}`);
  }
  return `${lines.join("\n")}\n`;
}
