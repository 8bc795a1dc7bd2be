/** Multi-axis runs: write or upload one, check it, start it, follow and cancel it. */

import { useEffect, useRef } from "preact/hooks";
import { saveFile } from "../../parts/files";
import { notify, notifyError } from "../../parts/notices";
import { link, may, readRuns } from "../../store";
import type { ViewEntry } from "../view";
import { checkRun, draft, isChecked, isGood, problems, startRun, verdict } from "./run_text";
import { RunList } from "./run_list";
import "../../parts/marked_text.css";
import "./runs.css";

const MOST_BYTES = 900_000;

function RunsView() {
  const connections = link.connections.value;
  useEffect(() => void readRuns(), [connections]);
  return (
    <div class="runs">
      <Editor />
      <RunList />
    </div>
  );
}

function Editor() {
  const attempt = (work: () => Promise<unknown>) => () => work().catch(notifyError);
  const upload = async (event: Event) => {
    const input = event.currentTarget as HTMLInputElement;
    const file = input.files?.[0];
    input.value = "";
    if (!file) return;
    if (file.size > MOST_BYTES) {
      notify(`${file.name} has ${file.size} bytes; a run has at most ${MOST_BYTES}`, true);
      return;
    }
    draft.open(await file.text(), file.name);
    await checkRun().catch(notifyError);
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
          <button type="button" disabled={isOff} onClick={attempt(checkRun)}>
            Check
          </button>
          <button type="button" class="primary" disabled={isOff} onClick={attempt(startRun)}>
            Start
          </button>
        </span>
      </div>
      <MarkedText />
      <div role="status" aria-live="polite">
        {isGood.value && <p class="good">{verdict.value}</p>}
        {isChecked.value && problems.value.length > 0 && <Problems />}
      </div>
    </section>
  );
}

/** A text with numbered lines; those with problems are marked. */
function MarkedText() {
  const area = useRef<HTMLTextAreaElement>(null);
  const numbers = useRef<HTMLDivElement>(null);
  const { text } = draft.value;
  const count = text.split("\n").length;
  const bad = new Set(problems.value.map((problem) => problem.line));
  const follow = () => {
    if (numbers.current && area.current) numbers.current.scrollTop = area.current.scrollTop;
  };
  return (
    <div class="marked-text">
      <div class="line-numbers mono" ref={numbers} aria-hidden="true">
        {Array.from({ length: count }, (_, at) => (
          <div key={at} class={bad.has(at + 1) ? "is-bad" : undefined}>
            {bad.has(at + 1) ? "●" : ""} {at + 1}
          </div>
        ))}
      </div>
      <textarea
        id="run-text"
        ref={area}
        class="mono"
        aria-label="Run, as YAML or JSON"
        aria-invalid={bad.size > 0}
        aria-describedby={bad.size > 0 ? "run-problems" : undefined}
        spellcheck={false}
        wrap="off"
        value={text}
        onInput={(event) => draft.type(event.currentTarget.value)}
        onScroll={follow}
      />
    </div>
  );
}

function Problems() {
  return (
    <ul id="run-problems" class="problem-list">
      {problems.value.map((problem, at) => (
        <li key={at}>
          {problem.line > 0 && (
            <button
              type="button"
              class="mono"
              aria-label={`Go to line ${problem.line}, column ${problem.column}`}
              onClick={() => goTo(problem.line, problem.column)}
            >
              {problem.line}:{problem.column}
            </button>
          )}
          <span class="problem">{problem.text}</span>
        </li>
      ))}
    </ul>
  );
}

/** Put the cursor to a place of the text. */
function goTo(line: number, column: number): void {
  const area = document.getElementById("run-text") as HTMLTextAreaElement | null;
  if (!area) return;
  const lines = area.value.split("\n");
  const start = lines.slice(0, line - 1).reduce((sum, each) => sum + each.length + 1, 0) + column - 1;
  area.focus();
  area.setSelectionRange(start, start + 1);
  area.scrollTop = Math.max(0, ((line - 4) / lines.length) * area.scrollHeight);
}

export const runsView: ViewEntry = { id: "runs", title: "Runs", View: RunsView };
