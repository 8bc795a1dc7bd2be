/** The run document that is being written, and what the bench says of it as it is typed. The text outlives the page. */

import { computed, effect, signal } from "@preact/signals";
import { Draft } from "../../kept";
import type { Operations } from "../../model/door";
import { type DocumentProblem, readProblems } from "../../model/problems";
import { exampleRun } from "../../model/run_example";
import { type RunPlan, readPlan } from "../../model/run_plan";
import { readRun } from "../../model/run_progress";
import { Refused } from "../../net/protocol";
import { measured } from "../../parts/text_size";
import { devices, hello, link, may, takeProgress } from "../../store";

/** A text is checked so long after the last key, a long one later. */
const PAUSE_MS = 400;
const LONG_PAUSE_MS = 1500;
const LONG_CHARACTERS = 100_000;
const PLAN_POINTS = 4000;

export const draft = new Draft("run", "the run", () => ({ text: exampleRun(devices.peek().values()), file: "run.yaml" }));
/** The text that the problems are of; null: none was checked. */
const checkedText = signal<string | null>(null);
/** Problems of the text that was checked last: they stay while the next check is under way. */
export const problems = signal<DocumentProblem[]>([]);
/** Plan of the last text without problems; null: there is none. */
export const plan = signal<RunPlan | null>(null);
/** What a good check said. */
export const verdict = signal("");
/** Why the text could not be checked; empty: it could. */
export const unchecked = signal("");

export const isChecked = computed(() => checkedText.value === draft.value.text);
export const isGood = computed(() => isChecked.value && problems.value.length === 0);

export const size = measured(
  () => [draft.value.text],
  () => hello.value?.message_bytes,
);
export const fits = computed(() => size.value.bytes <= size.value.most);

/** Ask for a run; what cannot be done as it is written is an answer with its problems. Throws other Refused. */
async function askRun(given: Operations["run"]["given"]): Promise<Record<string, unknown>> {
  try {
    return await link.ask("run", "", given);
  } catch (error) {
    if (!(error instanceof Refused) || error.code !== "bad_run") throw error;
    return { problems: error.problems.length ? error.problems : error.message };
  }
}

/** Check the text at the bench; nothing moves. Throws Refused. */
export async function checkRun(): Promise<boolean> {
  const { text: checked, file } = draft.peek();
  const answer = await askRun({ text: checked, file, check: true, points: PLAN_POINTS });
  if (checked !== draft.peek().text) return false;
  problems.value = readProblems(answer["problems"] ?? "");
  checkedText.value = checked;
  plan.value = readPlan(answer["plan"]) ?? plan.peek();
  unchecked.value = "";
  verdict.value = problems.value.length ? "" : `run ${String(answer["run"] ?? "")}, ${String(answer["steps"] ?? "?")} steps, no problems`;
  return problems.value.length === 0;
}

/** Check the text, and carry it out if it has no problems. Throws Refused. */
export async function startRun(): Promise<void> {
  if (!(await checkRun())) return;
  const { text, file } = draft.peek();
  const answer = await askRun({ text, file, fresh: true });
  if (answer["problems"] !== undefined) {
    problems.value = readProblems(answer["problems"]);
    return;
  }
  draft.saved(text);
  const run = readRun(answer);
  if (run) takeProgress(run);
}

/** Check the text whenever it, or the bench, has changed; answers what ends it. */
export function checkAsTyped(): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  const check = () => void checkRun().catch((error: unknown) => (unchecked.value = error instanceof Error ? error.message : String(error)));
  const stop = effect(() => {
    const { text } = draft.value;
    const isReady = hello.value !== null && link.state.value === "open" && may("operator") && fits.value;
    clearTimeout(timer);
    if (isReady) timer = setTimeout(check, text.length > LONG_CHARACTERS ? LONG_PAUSE_MS : PAUSE_MS);
  });
  return () => {
    clearTimeout(timer);
    stop();
  };
}
