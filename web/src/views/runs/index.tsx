/** Multi-axis runs: write or upload one, check it, start it, follow and cancel it. */

import { useEffect } from "preact/hooks";
import { keptFor } from "../../kept";
import { ProblemList } from "../../parts/editor/problem_list";
import { TextEditor } from "../../parts/editor/text_editor";
import { saveFile } from "../../parts/files";
import { notify, notifyError } from "../../parts/notices";
import { TextSize } from "../../parts/text_size";
import { whenLoaded } from "../../parts/when_loaded";
import { devices, link, may, readRuns } from "../../store";
import { RunList } from "./run_list";
import { checkAsTyped, checkRun, draft, fits, isChecked, isGood, problems, size, startRun, unchecked, verdict } from "./run_text";
import "./runs.css";

const PlanCard = whenLoaded(async () => (await import("./run_plan")).PlanCard);
const MOST_BYTES = 900_000;
const RUN = { kind: "RunDocument", devices: () => devices.peek().values() } as const;

export function RunsView() {
  const connections = link.connections.value;
  useEffect(() => void readRuns(), [connections]);
  useEffect(checkAsTyped, []);
  return (
    <div class="runs">
      <Editor />
      <div class="runs-column">
        <PlanCard />
        <RunList />
      </div>
    </div>
  );
}

function Editor() {
  const attempt = (work: () => Promise<unknown>) => () => work().catch(notifyError);
  const open = async (file: File) => {
    if (file.size > MOST_BYTES) {
      notify(`${file.name} has ${file.size} bytes; a run has at most ${MOST_BYTES}`, true);
      return;
    }
    draft.open(await file.text(), file.name);
    await checkRun().catch(notifyError);
  };
  const upload = async (event: Event) => {
    const input = event.currentTarget as HTMLInputElement;
    const file = input.files?.[0];
    input.value = "";
    if (file) await open(file);
  };
  const save = () => {
    const { text, file } = draft.peek();
    saveFile(file, new TextEncoder().encode(text));
    draft.saved(text);
  };
  const isOff = !may("operator");
  return (
    <section class="card" aria-label="Run document">
      <div class="card-head">
        <h2>Run</h2>
        <span class="mono soft file-name">{draft.value.file}</span>
        <span class="push row">
          <label class="button">
            Open a file
            <input class="out-of-sight" type="file" accept=".yaml,.yml,.json" onChange={(event) => void upload(event)} />
          </label>
          <button type="button" onClick={save}>
            Save
          </button>
          <button type="button" disabled={isOff || !fits.value} onClick={attempt(checkRun)}>
            Check
          </button>
          <button type="button" class={isGood.value ? "primary" : ""} disabled={isOff || !fits.value} onClick={attempt(startRun)}>
            Start
          </button>
        </span>
      </div>
      <TextEditor
        name="run"
        memory={`${keptFor.value}/run`}
        label="Run, as YAML or JSON"
        language={RUN}
        draft={draft}
        problems={problems.value}
        dropped={(file) => void open(file).catch(notifyError)}
      />
      <TextSize {...size.value} what="The run" />
      <div role="status" aria-live="polite">
        {isGood.value && <p class="good">{verdict.value}</p>}
        {!isChecked.value && unchecked.value && <p class="soft">Not checked: {unchecked.value}</p>}
      </div>
      <ProblemList of="run" title="Problems of the run" problems={problems.value} />
    </section>
  );
}
