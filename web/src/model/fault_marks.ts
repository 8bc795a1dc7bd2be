/** Faults on the time axis. Pure. */

export interface ActiveFault {
  number: number;
  kind: string;
  target: string;
  parameters: Record<string, unknown>;
}

/** A fault on the time axis: simulated seconds of its begin and end as this page saw them. `begin_s` is
 * -Infinity if it was there before the page, `end_s` is null while it is active. */
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
    const { number, kind, target, parameters } = (each ?? {}) as Record<string, unknown>;
    if (typeof number !== "number" || typeof kind !== "string" || typeof target !== "string") return [];
    return [{ number, kind, target, parameters: { ...(parameters as object | null) } }];
  });
}

const MOST_MARKS = 200;

/** Marks after the list of active faults changed: new ones were injected at `injectedAt_s`, those that are gone have
 * ended at `end_s`. */
export function marked(before: FaultMark[], now: ActiveFault[], injectedAt_s: (number: number) => number, end_s: number): FaultMark[] {
  const active = new Set(now.map((fault) => fault.number));
  const ended = before.map((mark) => (mark.end_s === null && !active.has(mark.number) ? { ...mark, end_s } : mark));
  const known = new Set(before.filter((mark) => mark.end_s === null).map((mark) => mark.number));
  const begun = now
    .filter((fault) => !known.has(fault.number))
    .map(({ number, kind, target, parameters }) => ({ number, kind, target, begin_s: injectedAt_s(number) + delay_s(parameters), end_s: null }));
  return [...ended, ...begun].slice(-MOST_MARKS);
}

function delay_s(parameters: Record<string, unknown>): number {
  const start_s = parameters["start_s"];
  return typeof start_s === "number" ? start_s : 0;
}

/** Marks after the bench said when exactly a fault was injected. */
export function injected(marks: FaultMark[], number: number, parameters: Record<string, unknown>, at_s: number): FaultMark[] {
  return marks.map((mark) => (mark.number === number && mark.end_s === null ? { ...mark, begin_s: at_s + delay_s(parameters) } : mark));
}

/** Say when a fault was: "12.3 s to 14.0 s", "since 12.3 s". */
export function timesText({ begin_s, end_s }: FaultMark): string {
  const begin = Number.isFinite(begin_s) ? `${begin_s.toFixed(1)} s` : "before this page";
  if (end_s === null) return Number.isFinite(begin_s) ? `since ${begin}` : `since ${begin} was opened`;
  return begin_s === end_s ? `at ${begin}` : `${begin} to ${end_s.toFixed(1)} s`;
}

/** Marks of a bench whose clock began anew: `by_s` earlier, and those that were active ended at `last_s`. */
export function movedBack(marks: FaultMark[], by_s: number, last_s: number): FaultMark[] {
  return marks.map((mark) => ({ ...mark, begin_s: mark.begin_s - by_s, end_s: (mark.end_s ?? last_s) - by_s }));
}
