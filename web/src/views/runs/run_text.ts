/** The run document that is being written, and what the bench said of it. The text outlives the page. */

import { computed, signal } from "@preact/signals";
import { Draft } from "../../kept";
import type { Operations } from "../../model/door";
import { type DocumentProblem, readProblems } from "../../model/problems";
import { readRun } from "../../model/run_progress";
import { Refused } from "../../net/protocol";
import { link, takeProgress } from "../../store";

const EXAMPLE = `run: example
axes:
steps:
`;
export const draft = new Draft("run", "the run", () => ({ text: EXAMPLE, file: "run.yaml" }));
/** The text that the problems are of; null: it has not been checked. */
const checkedText = signal<string | null>(null);
const found = signal<DocumentProblem[]>([]);
/** What a good check said. */
export const verdict = signal("");

/** Problems of the text as it stands; empty while it has changed since the check. */
export const problems = computed(() => (isChecked.value ? found.value : []));
export const isChecked = computed(() => checkedText.value === draft.value.text);
export const isGood = computed(() => isChecked.value && found.value.length === 0);

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
  const answer = await askRun({ text: checked, file, check: true });
  found.value = readProblems(answer["problems"] ?? "");
  checkedText.value = checked;
  verdict.value = found.value.length ? "" : `run ${String(answer["run"] ?? "")}, ${String(answer["steps"] ?? "?")} steps, no problems`;
  return found.value.length === 0;
}

/** Check the text, and carry it out if it has no problems. Throws Refused. */
export async function startRun(): Promise<void> {
  if (!(await checkRun())) return;
  const { text, file } = draft.peek();
  const answer = await askRun({ text, file, fresh: true });
  if (answer["problems"] !== undefined) {
    found.value = readProblems(answer["problems"]);
    return;
  }
  draft.saved(text);
  const run = readRun(answer);
  if (run) takeProgress(run);
}
