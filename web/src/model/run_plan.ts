/** Plan of a run, as the bench tells it before anything moves. Pure. */

export interface PlannedAxis {
  name: string;
  at_s: number[];
  position_deg: number[];
}

/** Step: its number from 1, and what it does. */
export interface PlannedStep {
  from_s: number;
  to_s: number;
  number: number;
  text: string;
}

export interface RunPlan {
  duration_s: number;
  /** False: boards make ramps of their own, or something is waited for. */
  isExact: boolean;
  axes: PlannedAxis[];
  steps: PlannedStep[];
  stepsLeftOut: number;
}

/** Read the plan of a check's answer; null: there is none. */
export function readPlan(raw: unknown): RunPlan | null {
  const told = object(raw);
  if (typeof told["duration_s"] !== "number") return null;
  return {
    duration_s: told["duration_s"],
    isExact: told["is_exact"] === true,
    axes: Object.entries(object(told["axes"])).map(([name, way]) => ({
      name,
      at_s: numbers(object(way)["at_s"]),
      position_deg: numbers(object(way)["position_deg"]),
    })),
    steps: list(told["steps"]).map(readStep),
    stepsLeftOut: numberOf(told["steps_left_out"]),
  };
}

function readStep(raw: unknown): PlannedStep {
  const [from_s, to_s, number, text] = list(raw);
  return { from_s: numberOf(from_s), to_s: numberOf(to_s), number: numberOf(number), text: String(text ?? "") };
}

/** Smallest and largest angle of all axes, with a little room; never empty. */
export function rangeOf(axes: readonly PlannedAxis[]): [number, number] {
  let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
  for (const { position_deg } of axes)
    for (const deg of position_deg) {
      low = Math.min(low, deg);
      high = Math.max(high, deg);
    }
  if (low > high) return [-1, 1];
  const room = (high - low) * 0.05 || 1;
  return [low - room, high + room];
}

/** Path of an axis, as of an SVG, in a box of so many units. */
export function pathOf(axis: PlannedAxis, duration_s: number, [low, high]: [number, number], width: number, height: number): string {
  const points = axis.at_s.map((at_s, at) => {
    const x = duration_s > 0 ? (at_s / duration_s) * width : 0;
    const y = height - (((axis.position_deg[at] ?? low) - low) / (high - low)) * height;
    return `${x.toFixed(1)} ${y.toFixed(1)}`;
  });
  return points.length ? `M${points.join("L")}` : "";
}

/** Angle of an axis at a time, between the points that there are; null: there are none. */
export function angleAt(axis: PlannedAxis, at_s: number): number | null {
  const { at_s: times, position_deg } = axis;
  const next = times.findIndex((each) => each >= at_s);
  if (next < 0) return position_deg.at(-1) ?? null;
  const [before, after] = [position_deg[Math.max(next - 1, 0)]!, position_deg[next]!];
  const [from_s, to_s] = [times[Math.max(next - 1, 0)]!, times[next]!];
  return to_s > from_s ? before + ((after - before) * (at_s - from_s)) / (to_s - from_s) : after;
}

/** Lanes for steps: of those that would cover each other each has another one; at most so many. */
export function laneOf(steps: readonly PlannedStep[], least_s: number, most: number): number[] {
  const ends_s: number[] = [];
  return steps.map(({ from_s, to_s }) => {
    let lane = ends_s.findIndex((end_s) => end_s <= from_s + 1e-9);
    if (lane < 0) lane = ends_s.length < most ? ends_s.length : most - 1;
    ends_s[lane] = Math.max(to_s, from_s + least_s);
    return lane;
  });
}

/** Line of a run's text at which a step begins, from its number; 0: it is not found, as in JSON in one line. */
export function lineOfStep(text: string, number: number): number {
  const lines = text.split("\n");
  const begin = lines.findIndex((line) => /^"?steps"?\s*:/.test(line));
  let indent = -1;
  let count = 0;
  for (let at = begin + 1; begin >= 0 && at < lines.length; at++) {
    const dash = /^(\s*)-(\s|$)/.exec(lines[at]!);
    if (!dash) continue;
    if (indent < 0) indent = dash[1]!.length;
    if (dash[1]!.length === indent && ++count === number) return at + 1;
  }
  return 0;
}

function object(value: unknown): Record<string, unknown> {
  return typeof value === "object" && value !== null && !Array.isArray(value) ? (value as Record<string, unknown>) : {};
}

function list(value: unknown): unknown[] {
  return Array.isArray(value) ? value : [];
}

function numbers(value: unknown): number[] {
  return list(value).map(numberOf);
}

function numberOf(value: unknown): number {
  return typeof value === "number" && Number.isFinite(value) ? value : 0;
}
