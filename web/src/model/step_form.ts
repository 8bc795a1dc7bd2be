/** Fields of a step response: how far, and for how long it is recorded. Pure. */

import { checkAll, type ParameterRow } from "./parameters";

export const STEP: ParameterRow = { name: "step_deg", unit: "deg", summary: "how far", minimum: -3600, maximum: 3600, default: 10 };
export const LENGTH: ParameterRow = { name: "length_s", unit: "s", summary: "recorded time after it", minimum: 0.05, maximum: 10, default: 0.5 };

/** Check what is typed of a step; a field that is empty has its usual value. */
export function checkStep(typed: Record<string, string>): { step_deg: number; length_s: number; problems: Record<string, string> } {
  const { values, problems } = checkAll([STEP, LENGTH], typed);
  const step_deg = Number(values["step_deg"] ?? STEP.default);
  const length_s = Number(values["length_s"] ?? LENGTH.default);
  return { step_deg, length_s, problems: step_deg === 0 ? { ...problems, step_deg: "0 deg is no step" } : problems };
}
