/** A run and a machine to begin with, for the axes that a bench has. Pure. */

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

const LINEAR = "min_mm: -100, max_mm: 100, velocity_mm_per_min: 3000, acceleration_mm_per_s2: 500";

/** Text of a machine whose X and Y are axes of the bench that follow paths; empty: it has none. */
export function exampleMachine(devices: Iterable<DeviceRow>): string {
  const axes = runAxes(devices)
    .filter(({ is_real, verbs }) => !is_real && "position" in verbs)
    .slice(0, 2);
  if (!axes.length) return "";
  const rows = axes.map(({ name }, at) => `  ${"xy"[at]}: {axis: ${name}, deg_per_mm: 9, ${LINEAR}}\n`).join("");
  return `machine: plotter\nsegment_ms: 10\naxes:\n${rows}`;
}
