/** The drawing that is worked on, and its runs. The texts outlive the page. */

import { computed, signal } from "@preact/signals";
import { Draft, Kept, remembered } from "../../kept";
import { decoded, type Drawing, type DrawingProblems, lineAt, partOf, readDrawing, shareDone } from "../../model/drawing";
import type { DocumentProblem } from "../../model/problems";
import { exampleMachine } from "../../model/run_example";
import { readRun, type RunProgress } from "../../model/run_progress";
import { Refused } from "../../net/protocol";
import { devices, link, may, runs, status, takeProgress } from "../../store";

/** Characters of a program that a bench reads. */
export const MOST_BYTES = 4 << 20;

export type Which = "program" | "machine";

const EXAMPLE = `G21 G90 G17
G0 X10 Y0
F1200
G3 I-10
G1 X0 Y0
M2
`;

/** The keys are those of pages up to 0.2, which kept one text for all benches. */
export const drafts = {
  program: new Draft("path.program", "the program", () => ({ text: remembered("hil.path.program") ?? EXAMPLE, file: "program.ngc" })),
  machine: new Draft("path.machine", "the machine", () => ({
    text: remembered("hil.path.machine") ?? exampleMachine(devices.peek().values()),
    file: "machine.yaml",
  })),
};
export const feed_percent = new Kept(
  "path.feed",
  () => 100,
  (raw) => (typeof raw === "number" && raw >= 1 && raw <= 200 ? raw : undefined),
);
/** The drawing that is shown: the bench's, or the one that was checked here. */
export const drawing = signal<Drawing | null>(null);
export const isPlanning = signal(false);
/** Problems of the texts that were checked last: they stay while the next check is under way. */
export const refused = signal<DrawingProblems | null>(null);
/** Text that has the focus: it is written at. */
export const focused = signal<Which | null>(null);
/** Texts that the problems are of. */
export const checked = signal<[string, string]>(["", ""]);
/** Digest of the drawing that was planned here last. */
const plannedHere = signal("");

export async function openFile(which: Which, file: File): Promise<void> {
  if (file.size > MOST_BYTES) throw new Error(`${file.name} has ${file.size} bytes: ${MOST_BYTES} are the most here`);
  drafts[which].open(decoded(new Uint8Array(await file.arrayBuffer())), file.name);
}

const NONE: DocumentProblem[] = [];

/** Problems of a text, as it was checked last. */
export function problemsOf(which: Which): DocumentProblem[] {
  return refused.value?.of === which ? refused.value.problems : NONE;
}

export const isChecked = computed(() => checked.value[0] === drafts.program.value.text && checked.value[1] === drafts.machine.value.text);
/** True if the texts as they stand were checked, and have no problems. */
export const isGood = computed(() => isChecked.value && refused.value === null);
/** Figures of the check; empty: it was not one as the texts were typed. */
export const verdict = signal("");
/** True if the drawing is that of the texts as they stand. */
export const isPlanned = computed(() => {
  const made = drawing.value;
  return made !== null && made.text === drafts.program.value.text && made.machineText === drafts.machine.value.text;
});

/** File of the bench's drawing, where the texts here are others that were not planned here; null: they are not. */
export const offered = computed(() => {
  const made = drawing.value;
  return made && !isPlanned.value && made.digest !== plannedHere.value ? (made.file ?? "another program") : null;
});

/** Ask the bench to read and plan the texts; `isCheck`: its problems and figures alone, for this page. Throws Refused. */
export async function ask(isCheck: boolean): Promise<{ texts: [string, string]; answer: unknown }> {
  const [program, machine] = [drafts.program.peek(), drafts.machine.peek()];
  const given = { text: program.text || " ", machine: machine.text || " ", file: program.file, machine_file: machine.file };
  const answer = await link.ask("drawing", "", { ...given, feed_percent: feed_percent.peek(), ...(isCheck ? { check: true } : {}) });
  return { texts: [program.text, machine.text], answer };
}

/** Let the bench read and plan the texts; nothing moves. Throws Refused. */
export async function plan(): Promise<boolean> {
  isPlanning.value = true;
  try {
    const { file } = drafts.program.peek();
    const { texts, answer } = await ask(false);
    const read = readDrawing(answer);
    if (read === null) throw new Error("the bench answered with something that is no drawing");
    checked.value = texts;
    verdict.value = "";
    refused.value = "problems" in read ? read : null;
    if (!("problems" in read)) {
      plannedHere.value = read.digest;
      drawing.value = { ...read, text: texts[0], machineText: texts[1], file };
    }
  } finally {
    isPlanning.value = false;
  }
  return refused.peek() === null;
}

/** The bench's drawing that was looked at last: one that was checked here, by a viewer, is not replaced by it. */
let seen = "";

/** Show the drawing that the bench has, if it is another one, so that all pages see the same. One that runs stays
 * until its end. */
export async function follow(): Promise<void> {
  const theirs = status.peek().drawing ?? "";
  if (theirs === seen || isUnderWay.peek() || isPlanning.peek()) return;
  if (theirs !== "" && theirs !== drawing.peek()?.digest) {
    const answer = await link.ask("drawing").catch((error: unknown) => {
      if (error instanceof Refused) return null;
      throw error;
    });
    const read = answer === null ? null : readDrawing(answer);
    if (read === null || "problems" in read || isUnderWay.peek()) return;
    show(read);
  }
  seen = theirs;
}

/** Show the bench's drawing; its texts, too, where nobody has written here. */
function show(read: Drawing): void {
  drawing.value = read;
  const isFree = focused.peek() === null && !drafts.program.peek().isOwn && !drafts.machine.peek().isOwn;
  if (isFree) takeTexts();
}

/** Take the texts of the drawing that is shown in the place of those here. */
export function takeTexts(): void {
  const made = drawing.peek();
  if (!made || made.text === null) return;
  drafts.program.take(made.text, made.file ?? "program.ngc");
  drafts.machine.take(made.machineText ?? "", "machine.yaml");
}

// ---- its runs ----

const isEnded = (each: RunProgress) => each.state !== "running" && each.state !== "queued";

/** The drawing's run: that which moves, else the last one. */
export const run = computed<RunProgress | null>(() => {
  const made = drawing.value;
  if (made === null) return null;
  const own = runs.value.filter((each) => partOf(each, made) !== null);
  return own.find((each) => !isEnded(each)) ?? own[0] ?? null;
});

/** A run of something else that moves axes of the drawing now. */
export const otherRun = computed<RunProgress | null>(() => {
  const made = drawing.value;
  if (made === null) return null;
  const isOurs = (axis: string) => made.axes.some((each) => each.axis === axis);
  return runs.value.find((each) => each.state === "running" && partOf(each, made) === null && Object.keys(each.axes).some(isOurs)) ?? null;
});

export const isUnderWay = computed(() => run.value !== null && !isEnded(run.value));
export const isPaused = computed(() => isUnderWay.value && run.value?.pace === 0);

export interface Done {
  part: number;
  share: number;
  line: number;
  left_s: number;
}

/** How far the drawing is. */
export const done = computed<Done | null>(() => {
  const [now, made] = [run.value, drawing.value];
  if (!now || !made) return null;
  const part = partOf(now, made) ?? 0;
  const own = made.parts[part];
  if (!own) return null;
  const gone_s = now.gone_ns / 1e9;
  const share = now.state === "done" ? shareDone(made.parts, part, own.duration_s) : shareDone(made.parts, part, gone_s);
  return { part, share, line: lineAt(own, gone_s), left_s: (1 - share) * made.figures.duration_s };
});

/** Part that can go on now: after a pause of the program that nobody has ended. */
export const nextPart = computed<number | null>(() => {
  const [now, made] = [run.value, drawing.value];
  if (!now || !made || now.state !== "done") return null;
  const part = partOf(now, made) ?? 0;
  return part + 1 < made.parts.length ? part + 1 : null;
});

/** Digest of the drawing that was started here: its parts go on by themselves, save after a pause of the program. */
let startedHere = "";
/** Part that was started last. */
let lastPart = 0;

/** Plan again, from where the axes are, and start. Throws Refused. */
export async function start(): Promise<void> {
  if (!(await plan())) return;
  startedHere = drawing.peek()?.digest ?? "";
  await startPart(0);
  const made = drawing.peek();
  drafts.program.saved(made?.text ?? "");
  drafts.machine.saved(made?.machineText ?? "");
}

export async function startPart(number: number): Promise<void> {
  const part = drawing.peek()?.parts[number];
  if (!part) return;
  lastPart = number;
  const answer = await link.ask("run", "", { text: part.text, file: "drawing", fresh: true });
  if ("problems" in answer) throw new Error(answer.problems.split("\n")[0]);
  const begun = readRun(answer);
  if (begun) takeProgress(begun);
}

/** Start the next part of what was started here, where nothing is waited for. Throws Refused. */
export async function goOn(): Promise<void> {
  const [next, made] = [nextPart.value, drawing.value];
  if (next === null || made?.digest !== startedHere || lastPart >= next || made.parts[next - 1]?.pause_line !== null) return;
  await startPart(next);
}

export async function setPace(pace: number): Promise<void> {
  const now = run.peek();
  if (!now) return;
  const told = readRun(await link.ask("pace_run", now.run, { pace }));
  if (told) takeProgress(told);
}

export async function stop(how: "grace" | "prejudice"): Promise<void> {
  const now = run.peek();
  if (!now) return;
  const told = readRun(await link.ask("cancel_run", now.run, { how }));
  if (told) takeProgress(told);
}

export const mayStart = computed(() => may("operator") && link.state.value === "open" && !isUnderWay.value && !otherRun.value && !isPlanning.value);
