/** What every view needs from the bench, watched while the page is open: status, faults, runs. */

import { type ActiveFault, marked, movedBack } from "./model/fault_marks";
import { RESTART_GAP_s } from "./model/ring";
import { link, activeFaults, benchTime_s, faultMarks, runs, status, statusBefore } from "./store";
import type { RunProgress, Status } from "./store";

const STATUS_RATE_HZ = 2;

export function startFeeds(): void {
  link.watch({ what: "status", rate_Hz: STATUS_RATE_HZ }, {
    value: (value) => {
      const now = (value ?? {}) as Status;
      const last_s = benchTime_s();
      const back_s = last_s - (now.sim_ns ?? 0) / 1e9;
      if (back_s > 0) faultMarks.value = movedBack(faultMarks.peek(), back_s + RESTART_GAP_s, last_s);
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

function takeRun(run: RunProgress): void {
  const others = runs.peek().filter((known) => known.run !== run.run);
  runs.value = [run, ...others].slice(0, 50);
}
