/** Runs and how far they are, as the bench tells. Pure. */

export interface AxisReport {
  target_deg: number | null;
  position_deg: number | null;
  error_max_deg: number | null;
  error_rms_deg: number | null;
  at_end: string | null;
}

export interface RunProgress {
  run: string;
  /** Digest of its text: what it is known by; empty: it is not told. */
  digest: string;
  state: string;
  step: number;
  steps: number;
  /** Simulated time at which the step began, exactly; null: none has, or that is not told. */
  step_at_ns: number | null;
  /** Simulated time at which it ends as planned; null: it is not known. */
  planned_end_ns: number | null;
  /** Simulated time at which it was begun; null: it waits, or that is not known. */
  started_at_ns: number | null;
  /** Simulated time at which it was over; null: it is not, or that is not known. */
  ended_at_ns: number | null;
  /** Time of its plan that is gone, and its pace: 1 as planned, 0 paused. */
  gone_ns: number;
  pace: number;
  why: string;
  axes: Record<string, AxisReport>;
}

const MOST_RUNS = 50;

/** Read the progress of a run; null: it is none. */
export function readRun(raw: unknown): RunProgress | null {
  const told = object(raw);
  if (typeof told["run"] !== "string") return null;
  return {
    run: told["run"],
    digest: typeof told["digest"] === "string" ? told["digest"] : "",
    state: String(told["state"] ?? ""),
    step: numberOf(told["step"]) ?? 0,
    steps: numberOf(told["steps"]) ?? 0,
    step_at_ns: numberOf(told["step_at_ns"]),
    planned_end_ns: numberOf(told["planned_end_ns"]),
    started_at_ns: numberOf(told["started_at_ns"]),
    ended_at_ns: numberOf(told["ended_at_ns"]),
    gone_ns: numberOf(told["gone_ns"]) ?? 0,
    pace: numberOf(told["pace"]) ?? 1,
    why: typeof told["why"] === "string" ? told["why"] : "",
    axes: Object.fromEntries(Object.entries(object(told["axes"])).map(([name, axis]) => [name, readAxis(axis)])),
  };
}

function readAxis(raw: unknown): AxisReport {
  const told = object(raw);
  return {
    target_deg: numberOf(told["target_deg"]),
    position_deg: numberOf(told["position_deg"]),
    error_max_deg: numberOf(told["error_max_deg"]),
    error_rms_deg: numberOf(told["error_rms_deg"]),
    at_end: typeof told["at_end"] === "string" ? told["at_end"] : null,
  };
}

/** List of runs after one of them went on: it stays in its place, a new one comes first. */
export function withRun(runs: RunProgress[], run: RunProgress): RunProgress[] {
  const isKnown = runs.some((known) => known.run === run.run);
  return isKnown ? runs.map((known) => (known.run === run.run ? run : known)) : [run, ...runs].slice(0, MOST_RUNS);
}

function object(value: unknown): Record<string, unknown> {
  return typeof value === "object" && value !== null && !Array.isArray(value) ? (value as Record<string, unknown>) : {};
}

function numberOf(value: unknown): number | null {
  return typeof value === "number" && Number.isFinite(value) ? value : null;
}
