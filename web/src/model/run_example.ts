/** A run to begin with, for the axes that a bench has. Pure. */

import { runAxes } from "./document_guide";
import type { DeviceRow } from "./door";

/** As many axes of the bench are in it. */
const MOST_AXES = 2;

/** Text of a run that moves axes of the bench there and back. */
export function exampleRun(devices: Iterable<DeviceRow>): string {
  const axes = runAxes(devices)
    .filter(({ is_real }) => !is_real)
    .slice(0, MOST_AXES);
  if (!axes.length) return "run: example\naxes:\nsteps:\n";
  const limits = axes.map(({ name }) => `  ${name}: {velocity_rpm: 60}\n`).join("");
  const to = (by_deg: number) => `{${axes.map(({ name }, at) => `${name}: ${at % 2 ? -by_deg : by_deg}`).join(", ")}}`;
  return `# Axes of this bench turn by 90 degrees and back.
run: example
axes:
${limits}steps:
- move_by: ${to(90)}
- dwell_s: 0.5
- move_by: ${to(-90)}
`;
}
