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

const MOST_MARKS = 200;

/** Marks after the list of active faults changed: new ones begin, those that are gone have ended. */
export function marked(before: FaultMark[], now: ActiveFault[], begin_s: number, end_s: number): FaultMark[] {
  const active = new Set(now.map((fault) => fault.number));
  const ended = before.map((mark) => (mark.end_s === null && !active.has(mark.number) ? { ...mark, end_s } : mark));
  const known = new Set(before.filter((mark) => mark.end_s === null).map((mark) => mark.number));
  const begun = now
    .filter((fault) => !known.has(fault.number))
    .map(({ number, kind, target }) => ({ number, kind, target, begin_s, end_s: null }));
  return [...ended, ...begun].slice(-MOST_MARKS);
}

/** Marks of a bench whose clock began anew: `by_s` earlier, and those that were active ended at `last_s`. */
export function movedBack(marks: FaultMark[], by_s: number, last_s: number): FaultMark[] {
  return marks.map((mark) => ({ ...mark, begin_s: mark.begin_s - by_s, end_s: (mark.end_s ?? last_s) - by_s }));
}
