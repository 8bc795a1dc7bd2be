/** The drawing that is worked on, and its runs. It outlives the view. */

import { computed, signal } from "@preact/signals";
import { decoded, type Drawing, type DrawingProblems, lineAt, partOf, readDrawing, shareDone } from "../../model/drawing";
import type { DocumentProblem } from "../../model/problems";
import { readRun, type RunProgress } from "../../model/run_progress";
import { Refused } from "../../net/protocol";
import { link, may, runs, takeProgress } from "../../store";

/** Most characters of a program that are kept for the next visit. */
const MOST_KEPT = 500_000;
export const MOST_BYTES = 900_000;
const KEYS = { program: "hil.path.program", machine: "hil.path.machine" };

export type Which = "program" | "machine";

const EXAMPLE = `G21 G90 G17
G0 X10 Y0
F1200
G3 I-10
G1 X0 Y0
M2
`;

export const texts = {
  program: signal(localStorage.getItem(KEYS.program) ?? EXAMPLE),
  machine: signal(localStorage.getItem(KEYS.machine) ?? ""),
};
export const names = { program: signal("program.ngc"), machine: signal("machine.yaml") };
export const feed_percent = signal(100);
export const drawing = signal<Drawing | null>(null);
export const isPlanning = signal(false);
const refused = signal<DrawingProblems | null>(null);
/** Text that has the focus: it is written at. */
export const focused = signal<Which | null>(null);
/** Texts that the problems are of. */
const checked = signal<[string, string]>(["", ""]);

export function setText(which: Which, text: string): void {
  texts[which].value = text;
  if (text.length > MOST_KEPT) return;
  try {
    localStorage.setItem(KEYS[which], text);
  } catch {
    localStorage.removeItem(KEYS[which]); // no room is left: the next visit begins without it
  }
}

export async function openFile(which: Which, file: File): Promise<void> {
  if (file.size > MOST_BYTES) throw new Error(`${file.name} has ${file.size} bytes: ${MOST_BYTES} are the most here`);
  setText(which, decoded(new Uint8Array(await file.arrayBuffer())));
  names[which].value = file.name;
}

/** Problems of a text as it stands; empty while it has changed since the check. */
export function problemsOf(which: Which): DocumentProblem[] {
  const now = refused.value;
  const isSame = checked.value[0] === texts.program.value && checked.value[1] === texts.machine.value;
  return now?.of === which && isSame ? now.problems : [];
}

/** True if the drawing is that of the texts as they stand. */
export const isPlanned = computed(() => drawing.value !== null && checked.value[0] === texts.program.value && checked.value[1] === texts.machine.value);

/** Let the bench read and plan the texts; nothing moves. Throws Refused. */
export async function plan(): Promise<boolean> {
  const [program, machine] = [texts.program.peek(), texts.machine.peek()];
  isPlanning.value = true;
  try {
    const given = { text: program || " ", machine: machine || " ", file: names.program.peek(), machine_file: names.machine.peek() };
    take(await link.ask("drawing", "", { ...given, feed_percent: feed_percent.peek() }), program, machine);
  } finally {
    isPlanning.value = false;
  }
  return refused.peek() === null;
}

function take(answer: unknown, program: string, machine: string): void {
  const read = readDrawing(answer);
  if (read === null) throw new Error("the bench answered with something that is no drawing");
  checked.value = [program, machine];
  if ("problems" in read) {
    refused.value = read;
  } else {
    refused.value = null;
    former.value = new Set(runs.peek().filter(isEnded).map(keyOf));
    drawing.value = read;
  }
}

/** Take the drawing that the bench has, so that all pages see the same; its texts too, unless one of ours has the
 * focus: what is typed next would land in a text that just came. */
export async function follow(): Promise<void> {
  const before = [texts.program.peek(), texts.machine.peek()];
  const answer = await link.ask("drawing").catch((error: unknown) => {
    if (error instanceof Refused) return null;
    throw error;
  });
  const read = answer === null ? null : readDrawing(answer);
  if (read === null || "problems" in read || read.text === null) return;
  if (before[0] !== texts.program.peek() || before[1] !== texts.machine.peek()) return; // somebody writes here
  checked.value = [read.text, read.machineText ?? ""];
  if (focused.peek() === null) {
    [texts.program.value, texts.machine.value] = checked.peek();
    names.program.value = read.file ?? "program";
  }
  refused.value = null;
  former.value = new Set();
  drawing.value = read;
}

// ---- its runs ----

/** Runs that had ended when the drawing was planned here: another drawing's, of the same machine. */
const former = signal<ReadonlySet<string>>(new Set());

/** Key of a run: names begin anew with each start of the bench. */
const keyOf = (each: RunProgress) => `${each.run} ${each.started_at_ns}`;
const isEnded = (each: RunProgress) => each.state !== "running" && each.state !== "queued";

/** The drawing's run: that which moves, else the last one. */
export const run = computed<RunProgress | null>(() => {
  const machine = drawing.value?.machine;
  if (machine === undefined) return null;
  const own = runs.value.filter((each) => partOf(each.run, machine) !== null && !former.value.has(keyOf(each)));
  return own.find((each) => !isEnded(each)) ?? own[0] ?? null;
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
  const part = partOf(now.run, made.machine) ?? 0;
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
  const part = partOf(now.run, made.machine) ?? 0;
  return part + 1 < made.parts.length ? part + 1 : null;
});

/** Plan again, from where the axes are, and start. Throws Refused. */
export async function start(): Promise<void> {
  if (await plan()) await startPart(0);
}

export async function startPart(number: number): Promise<void> {
  const part = drawing.peek()?.parts[number];
  if (!part) return;
  const answer = await link.ask("run", "", { text: part.text, file: "drawing", fresh: true });
  if ("problems" in answer) throw new Error(answer.problems.split("\n")[0]);
  const begun = readRun(answer);
  if (begun) takeProgress(begun);
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

export const mayStart = computed(() => may("operator") && link.state.value === "open" && !isUnderWay.value && !isPlanning.value);
