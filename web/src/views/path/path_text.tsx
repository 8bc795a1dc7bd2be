/** A program or a machine's document as text, with numbered lines; those with problems are marked. */

import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { DocumentProblem } from "../../model/problems";
import { saveFile } from "../../parts/files";
import { notifyError } from "../../parts/notices";
import { drafts, focused, openFile, problemsOf, type Which } from "./path_state";

/** A text with a longer line, or longer, is not shown: a browser would stand still. */
const LONGEST_LINE = 20_000;
const MOST_SHOWN = 2_000_000;
const LINE_PX = 20;
const LISTED = 200;
const scrolled = { program: signal(0), machine: signal(0) };
const lineNow = signal(0);

/** Mark the line that is carried out. */
export function markLine(line: number): void {
  lineNow.value = line;
}

export function PathText({ which, title }: { which: Which; title: string }) {
  const { text, file } = drafts[which].value;
  const problems = problemsOf(which);
  const isShown = text.length <= MOST_SHOWN && !hasLongLine(text);
  const open = async (event: Event) => {
    const input = event.currentTarget as HTMLInputElement;
    const chosen = input.files?.[0];
    input.value = "";
    if (chosen) await openFile(which, chosen).catch(notifyError);
  };
  const save = () => {
    saveFile(file, new TextEncoder().encode(text));
    drafts[which].saved(text);
  };
  return (
    <section class="card" aria-label={title}>
      <div class="card-head">
        <h2>{title}</h2>
        <span class="mono soft file-name">{file}</span>
        <label class="button push">
          Open a file
          <input class="out-of-sight" type="file" aria-label={`Open a file: ${title}`} onChange={(event) => void open(event)} />
        </label>
        <button type="button" aria-label={`Save to a file: ${title}`} onClick={save}>
          Save
        </button>
      </div>
      {isShown ? (
        <NumberedText which={which} title={title} text={text} problems={problems} />
      ) : (
        <p class="soft">
          {text.length} characters, with lines that are too long to be shown.{" "}
          <button type="button" onClick={() => drafts[which].type("")}>
            Clear
          </button>
        </p>
      )}
      {problems.length > 0 && <Problems which={which} problems={problems} />}
    </section>
  );
}

function NumberedText({ which, title, text, problems }: { which: Which; title: string; text: string; problems: DocumentProblem[] }) {
  const numbers = useRef<HTMLDivElement>(null);
  useEffect(() => () => void (focused.value = null), []);
  const count = countLines(text);
  const first = Math.max(Math.floor(scrolled[which].value / LINE_PX) - 2, 0);
  const shown = Math.min(count - first, 40);
  const bad = new Set(problems.map((problem) => problem.line));
  return (
    <div class={`marked-text path-text is-${which}`}>
      <div class="line-numbers mono" ref={numbers} aria-hidden="true">
        <div class="path-numbers" style={{ top: `${first * LINE_PX - scrolled[which].value}px` }}>
          {Array.from({ length: shown }, (_, at) => {
            const line = first + at + 1;
            const isNow = which === "program" && line === lineNow.value;
            return (
              <div key={at} class={bad.has(line) ? "is-bad" : isNow ? "is-now" : undefined}>
                {bad.has(line) ? "●" : isNow ? "▶" : ""} {line}
              </div>
            );
          })}
        </div>
      </div>
      <textarea
        id={`path-${which}`}
        class="mono"
        aria-label={title}
        aria-invalid={bad.size > 0}
        aria-describedby={bad.size > 0 ? `path-${which}-problems` : undefined}
        spellcheck={false}
        wrap="off"
        value={text}
        onFocus={() => (focused.value = which)}
        onBlur={() => (focused.value = null)}
        onInput={(event) => drafts[which].type(event.currentTarget.value)}
        onScroll={(event) => (scrolled[which].value = event.currentTarget.scrollTop)}
      />
    </div>
  );
}

function Problems({ which, problems }: { which: Which; problems: DocumentProblem[] }) {
  return (
    <ul id={`path-${which}-problems`} class="problem-list" role="list" aria-label={`Problems of the ${which}`}>
      {problems.slice(0, LISTED).map((problem, at) => (
        <li key={at}>
          {problem.line > 0 && (
            <button
              type="button"
              class="mono"
              aria-label={`${problem.line}:${problem.column}, go to this line and column`}
              onClick={() => goTo(which, problem)}
            >
              {problem.line}:{problem.column}
            </button>
          )}
          <span class="problem">{problem.text}</span>
        </li>
      ))}
      {problems.length > LISTED && <li class="soft">and {problems.length - LISTED} more</li>}
    </ul>
  );
}

/** Put the cursor to a place of the text. */
function goTo(which: Which, { line, column }: DocumentProblem): void {
  const area = document.getElementById(`path-${which}`) as HTMLTextAreaElement | null;
  if (!area) return;
  let start = 0;
  for (let at = 1; at < line; at++) {
    const next = area.value.indexOf("\n", start);
    if (next < 0) break;
    start = next + 1;
  }
  start += Math.max(column - 1, 0);
  area.focus();
  area.setSelectionRange(start, start + 1);
  area.scrollTop = Math.max(0, (line - 4) * LINE_PX);
}

function countLines(text: string): number {
  let count = 1;
  for (let at = text.indexOf("\n"); at >= 0; at = text.indexOf("\n", at + 1)) count++;
  return count;
}

function hasLongLine(text: string): boolean {
  let begin = 0;
  while (begin <= text.length) {
    const end = text.indexOf("\n", begin);
    if ((end < 0 ? text.length : end) - begin > LONGEST_LINE) return true;
    if (end < 0) return false;
    begin = end + 1;
  }
  return false;
}
