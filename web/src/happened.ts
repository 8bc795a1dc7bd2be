/** What happened to the bench and in this page, for the list of events, the time line and the plots. */

import { computed, signal } from "@preact/signals";
import { type EventRow, type EventRows, marksWith, NO_EVENTS, readEvent, withRows } from "./model/bench_events";
import type { PastMark } from "./model/past";
import { benchTime_s, hello, link } from "./store";

const told = signal<EventRows>(NO_EVENTS);
/** Events that the bench left out before the page came. */
const lost = signal(0);

/** Rows, the oldest first, and how many are missing. */
export const happened = computed<EventRows>(() => ({ rows: told.value.rows, leftOut: told.value.leftOut + lost.value }));

export function instance(): string {
  return hello.peek()?.instance ?? "";
}

/** Watch what happens to the bench, while the page is open. */
export function followEvents(): void {
  link.watch(
    { what: "events" },
    {
      items: (items, left) => {
        const here = instance();
        const rows = items.map((each) => readEvent(each, here)).filter((row) => row !== null);
        told.value = withRows(told.peek(), rows);
        lost.value = left;
      },
    },
  );
}

let saidHere = 0;

/** Keep what the page said, when its message has gone from the screen. */
export function noteHere(text: string, isError: boolean): void {
  const at_s = benchTime_s();
  const row: EventRow = {
    key: `page ${++saidHere}`,
    kind: isError ? "refusals" : "page",
    at_s,
    to_s: at_s,
    of: "",
    who: "this page",
    text,
    count: 1,
    instance: instance(),
  };
  told.value = withRows(told.peek(), [row]);
}

/** Marks of a time line, with what the recording does not have. */
export function withHappened(recorded: readonly PastMark[]): PastMark[] {
  return marksWith(recorded, told.value.rows, hello.value?.instance ?? "");
}
