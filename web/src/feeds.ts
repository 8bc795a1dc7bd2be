/** What every view needs from the bench, watched while the page is open: status, faults, runs. */

import { link, activeFaults, benchTime_s, faultMarks, runs, status, statusBefore } from "./store";
import type { ActiveFault, FaultMark, RunProgress, Status } from "./store";

const STATUS_RATE_HZ = 2;
const MOST_MARKS = 200;

export function startFeeds(): void {
  link.watch({ what: "status", rate_Hz: STATUS_RATE_HZ }, {
    value: (value) => {
      statusBefore.value = status.peek();
      status.value = (value ?? {}) as Status;
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
