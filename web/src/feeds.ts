/** What every view needs from the bench, watched while the page is open: status, faults, runs. */

import { followEvents } from "./happened";
import { marked, movedBack, readFaults } from "./model/fault_marks";
import { RESTART_GAP_s } from "./model/ring";
import { readRun } from "./model/run_progress";
import { readStatus } from "./model/status";
import { activeFaults, benchTime_s, faultMarks, hello, link, takeProgress, takeStatus, toldTime_s } from "./store";

const STATUS_RATE_HZ = 2;

export function startFeeds(): void {
  followEvents();
  let instance: string | undefined;
  link.watch(
    { what: "status", rate_Hz: STATUS_RATE_HZ },
    {
      value: (value) => {
        const now = readStatus(value);
        const last_s = toldTime_s();
        const back_s = last_s - (now.sim_ns ?? 0) / 1e9;
        const here = hello.peek()?.instance;
        if (instance !== undefined && instance !== here) {
          faultMarks.value = movedBack(faultMarks.peek(), back_s + RESTART_GAP_s, last_s);
        }
        instance = here;
        takeStatus(now);
      },
    },
  );
  link.watch(
    { what: "faults" },
    {
      value: (value) => {
        const now = readFaults(value);
        faultMarks.value = marked(faultMarks.peek(), now, benchTime_s());
        activeFaults.value = now;
      },
    },
  );
  link.watch(
    { what: "runs" },
    {
      items: (items) => {
        for (const item of items) takeRun(item);
      },
    },
  );
}

function takeRun(item: unknown): void {
  const run = readRun(item);
  if (run) takeProgress(run);
}
