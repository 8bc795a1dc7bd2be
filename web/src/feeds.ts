/** What every view needs from the bench, watched while the page is open: status, faults, runs. */

import { RESTART_GAP_s } from "./model/ring";
import { link, activeFaults, benchTime_s, faultMarks, runs, status, statusBefore } from "./store";
import type { ActiveFault, FaultMark, RunProgress, Status } from "./store";

const STATUS_RATE_HZ = 2;
const MOST_MARKS = 200;

export function startFeeds(): void {
  link.watch({ what: "status", rate_Hz: STATUS_RATE_HZ }, {
    value: (value) => {
      const now = (value ?? {}) as Status;
      const back_s = ((status.peek().sim_ns ?? 0) - (now.sim_ns ?? 0)) / 1e9;
      if (back_s > 0) faultMarks.value = movedBack(faultMarks.peek(), back_s + RESTART_GAP_s);
      statusBefore.value = status.peek();
      status.value = now;
    },
  });
  let isFirst = true;
  link.watch({ what: "faults" }, {
    value: (value) => {
      const now = Array.isArray(value) ? (value as ActiveFault[]) : [];
      faultMarks.value = marked(faultMarks.peek(), now, isFirst ? -Infinity : benchTime_s(), benchTime_s());
      activeFaults.value = now;
      isFirst = false;
    },
  });
  link.watch({ what: "runs" }, {
    items: (items) => {
      for (const item of items) takeRun(item as RunProgress);
    },
  });
}

/** Marks of a bench whose clock began anew: those of the time before end there, as the samples do. */
export function movedBack(marks: FaultMark[], by_s: number): FaultMark[] {
  return marks.map((mark) => ({ ...mark, begin_s: mark.begin_s - by_s, end_s: (mark.end_s ?? by_s - RESTART_GAP_s) - by_s }));
}

/** Marks after the list of active faults changed: new ones begin, those that are gone have ended. */
export function marked(before: FaultMark[], now: ActiveFault[], begin_s: number, end_s: number): FaultMark[] {
  const active = new Set(now.map((fault) => fault.number));
  const ended = before.map((mark) =>
    mark.end_s === null && !active.has(mark.number) ? { ...mark, end_s } : mark,
  );
  const known = new Set(before.filter((mark) => mark.end_s === null).map((mark) => mark.number));
  const begun = now
    .filter((fault) => !known.has(fault.number))
    .map(({ number, kind, target }) => ({ number, kind, target, begin_s, end_s: null }));
  return [...ended, ...begun].slice(-MOST_MARKS);
}

function takeRun(run: RunProgress): void {
  const others = runs.peek().filter((known) => known.run !== run.run);
  runs.value = [run, ...others].slice(0, 50);
}
