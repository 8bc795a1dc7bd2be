/** Faults on the time axis. Pure. */

export interface ActiveFault {
  number: number;
  kind: string;
  target: string;
  parameters: Record<string, unknown>;
  /** Simulated time at which it begins; null: it is not told. */
  begin_s: number | null;
}

/** A fault on the time axis: simulated seconds of its begin and end. `end_s` is when the page saw that it had ended, or
 * null while it is active. */
export interface FaultMark {
  number: number;
  kind: string;
  target: string;
  begin_s: number;
  end_s: number | null;
}

/** Read the list of active faults; what is none is left out. */
export function readFaults(raw: unknown): ActiveFault[] {
  return (Array.isArray(raw) ? (raw as unknown[]) : []).flatMap((each) => {
    const { number, kind, target, parameters, begin_ns } = (each ?? {}) as Record<string, unknown>;
    if (typeof number !== "number" || typeof kind !== "string" || typeof target !== "string") return [];
    const begin_s = typeof begin_ns === "number" ? begin_ns / 1e9 : null;
    return [{ number, kind, target, parameters: { ...(parameters as object | null) }, begin_s }];
  });
}

const MOST_MARKS = 200;

/** Marks after the list of active faults changed, at `now_s`: new ones begin, those that are gone have ended. A fault that
 * comes again has a mark for each time. */
export function marked(before: FaultMark[], now: ActiveFault[], now_s: number): FaultMark[] {
  const active = new Map(now.map((fault) => [fault.number, fault]));
  const ended = before.map((mark) => {
    if (mark.end_s !== null) return mark;
    const fault = active.get(mark.number);
    if (!fault) return { ...mark, end_s: Math.max(now_s, mark.begin_s) };
    return comesAgain(mark, fault) ? { ...mark, end_s: mark.begin_s + length_s(fault) } : mark;
  });
  const known = new Set(ended.filter((mark) => mark.end_s === null).map((mark) => mark.number));
  const begun = now
    .filter((fault) => !known.has(fault.number))
    .map(({ number, kind, target, begin_s }) => ({ number, kind, target, begin_s: begin_s ?? now_s, end_s: null }));
  return [...ended, ...begun].slice(-MOST_MARKS);
}

function comesAgain(mark: FaultMark, fault: ActiveFault): boolean {
  return fault.begin_s !== null && fault.parameters["every_s"] !== undefined && fault.begin_s > mark.begin_s + 1e-6;
}

function length_s(fault: ActiveFault): number {
  const for_s = fault.parameters["for_s"];
  return typeof for_s === "number" ? for_s : 0;
}

/** Say when a fault was: "12.3 s to 14.0 s", "since 12.3 s". */
export function timesText({ begin_s, end_s }: FaultMark): string {
  const begin = `${begin_s.toFixed(1)} s`;
  if (end_s === null) return `since ${begin}`;
  return begin_s === end_s ? `at ${begin}` : `${begin} to ${end_s.toFixed(1)} s`;
}

/** Marks of a bench whose clock began anew: `by_s` earlier, and those that were active ended at `last_s`. */
export function movedBack(marks: FaultMark[], by_s: number, last_s: number): FaultMark[] {
  return marks.map((mark) => ({ ...mark, begin_s: mark.begin_s - by_s, end_s: (mark.end_s ?? last_s) - by_s }));
}
