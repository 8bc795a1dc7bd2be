/** Looking back: the time of the run that the page shows, while it is not the present. */

import { computed, effect, signal } from "@preact/signals";
import { withHappened } from "./happened";
import type { FaultMark } from "./model/fault_marks";
import { type PastMark, readMarks } from "./model/past";
import type { Operations } from "./model/door";
import { Refused } from "./net/protocol";
import { path } from "./router";
import { faultMarks, isPast, link } from "./store";

/** Time of the run that is shown, in s; null: the present. */
export const pastAt = signal<number | null>(null);
/** Marks of the recording. */
const recorded = signal<PastMark[]>([]);
/** Marks of the time line. */
export const marks = computed<PastMark[]>(() => withHappened(recorded.value));
/** Length of the recording so far; 0: it is not known. */
export const end_s = signal(0);
/** Up to here any time is there at once. */
export const ready_s = signal(0);
/** Why there is nothing to look back at, or nothing more; empty: there is. */
export const trouble = signal("");
/** Factor at which time goes on by itself; 0: it stands. */
export const pace = signal(0);

/** Requests of this page of which the newest alone counts have its name. */
export const LANE = Math.random().toString(36).slice(2);

/** Views that show the past. */
export const HAS_PAST = ["bench", "events", "layout", "wire"];
const OVERVIEW_EVERY_MS = 1000;
const PLAY_EVERY_MS = 50;
let revision = -1;

/** Faults to be drawn beside traces: of the recording where the page looks back. */
export const shownFaults = computed<FaultMark[]>(() => {
  if (pastAt.value === null) return faultMarks.value;
  return marks.value
    .filter((mark) => mark.lane === "faults")
    .map(({ text, of, from_s, to_s }, number) => ({ number, kind: text.split(" ")[0] ?? text, target: of, begin_s: from_s, end_s: to_s }));
});

/** Something that happened, as plots draw it. */
export interface PlotMark {
  at_s: number;
  text: string;
  kind: string;
}

/** Faults have bands, and lateness would be everywhere. */
const PLOTTED = ["runs", "verbs", "refusals", "stops", "reloads", "trouble"];

/** What happened, for the plots. */
export const plotMarks = computed<PlotMark[]>(() =>
  marks.value
    .filter(({ lane }) => PLOTTED.includes(lane))
    .map(({ lane, from_s, text, of }) => ({ at_s: from_s, text: of && !text.includes(of) ? `${of} ${text}` : text, kind: lane })),
);

/** Show a time of the run; its end, or more, is the present. */
export function lookAt(at_s: number): void {
  if (at_s >= end_s.peek()) live();
  else pastAt.value = Math.max(at_s, 0);
}

export function live(): void {
  pace.value = 0;
  pastAt.value = null;
}

/** Ask about the past; null where a newer request took its place, or nothing can be had. */
export async function askPast<Name extends keyof Operations>(operation: Name, given: Operations[Name]["given"]): Promise<Operations[Name]["answer"] | null> {
  try {
    return await link.ask(operation, "", given);
  } catch (error) {
    if (error instanceof Refused && error.code === "bad_parameter") throw error;
    if (error instanceof Refused && error.code === "cannot") trouble.value = error.message;
    return null;
  }
}

/** Keep the overview fresh while a time line is in sight; answers the function that ends it. */
export function followOverview(): () => void {
  const timer = window.setInterval(() => void readOverview(), OVERVIEW_EVERY_MS);
  void readOverview();
  return () => window.clearInterval(timer);
}

let isReading = false;

async function readOverview(): Promise<void> {
  if (isReading || document.hidden || link.state.peek() !== "open") return;
  isReading = true;
  try {
    const told = await link.ask("past", "", { revision });
    end_s.value = told.end_ns / 1e9;
    ready_s.value = told.ready_ns / 1e9;
    trouble.value = told.problem;
    revision = told.revision;
    if (told.marks) recorded.value = readMarks(told.marks);
  } catch (error) {
    if (error instanceof Refused && error.code !== "gone") trouble.value = error.message;
  } finally {
    isReading = false;
  }
}

effect(() => {
  isPast.value = pastAt.value !== null;
});

/** Views that show the present alone. */
effect(() => {
  if (!HAS_PAST.includes(path.value[0] ?? HAS_PAST[0]!)) live();
});

effect(() => {
  void link.connections.value; // the bench may have begun a new run
  revision = -1;
  recorded.value = [];
  live();
});

/** Let the shown time go on while there is a pace. */
effect(() => {
  const by = pace.value;
  if (!by) return;
  let before_ms = performance.now();
  const timer = window.setInterval(() => {
    const now_ms = performance.now();
    const at = pastAt.peek();
    if (at !== null) lookAt(at + ((now_ms - before_ms) / 1000) * by);
    before_ms = now_ms;
  }, PLAY_EVERY_MS);
  return () => window.clearInterval(timer);
});
