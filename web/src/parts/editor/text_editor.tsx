/** A text with an editor: numbers, marks of problems, completion, search, undo. The editor is loaded when it is used. */

import { useSignal } from "@preact/signals";
import { useEffect, useId, useRef } from "preact/hooks";
import type { DocumentProblem } from "../../model/problems";
import type { CodeEditor } from "./code_editor";
import type { CursorPlace, EditedText, TextLanguage } from "./editor_options";
import "./editor.css";

interface Props {
  /** Where problems lead to: see `goTo`. */
  name: string;
  /** What can be undone stays for it, over changes of the view. */
  memory: string;
  label: string;
  language: TextLanguage;
  draft: EditedText;
  problems: readonly DocumentProblem[];
  /** Line that is carried out; 0: none is. */
  lineNow?: number;
  focused?(isFocused: boolean): void;
  dropped(file: File): void;
}

/** Editors that are open, by name. */
const open = new Map<string, CodeEditor>();

/** Put the cursor of an editor to a place. */
export function goTo(name: string, { line, column }: { line: number; column: number }): void {
  open.get(name)?.goTo(line, column);
}

export function TextEditor(props: Props) {
  const { name, memory, label, draft, problems, lineNow = 0 } = props;
  const { text } = draft.value;
  const host = useRef<HTMLDivElement>(null);
  const editor = useRef<CodeEditor | null>(null);
  const now = useRef(props);
  now.current = props;
  const state = useSignal<"loading" | "open" | "failed">("loading");
  const place = useSignal<CursorPlace>({ line: 1, column: 1, meaning: "" });
  const hintId = useId();

  useEffect(() => {
    let isGone = false;
    const begin = async () => {
      const { CodeEditor } = await import("./code_editor");
      if (isGone || !host.current) return;
      const made = new CodeEditor(host.current, memory, draft.peek().text, {
        label,
        hintId,
        language: now.current.language,
        typed: (typed) => draft.type(typed),
        moved: (to) => (place.value = to),
        focused: (isFocused) => now.current.focused?.(isFocused),
        dropped: (file) => now.current.dropped(file),
      });
      made.setProblems(now.current.problems);
      made.mark(now.current.lineNow ?? 0);
      editor.current = made;
      open.set(name, made);
      state.value = "open";
    };
    begin().catch(() => (state.value = isGone ? state.peek() : "failed"));
    return () => {
      isGone = true;
      now.current.focused?.(false);
      editor.current?.close();
      editor.current = null;
      open.delete(name);
      state.value = "loading";
    };
  }, [memory, name, draft]);
  // What was typed since this was drawn is newer than what was drawn.
  useEffect(() => editor.current?.setText(draft.peek().text), [text]);
  useEffect(() => editor.current?.setProblems(problems), [problems]);
  useEffect(() => editor.current?.mark(lineNow), [lineNow]);

  const { line, column, meaning } = place.value;
  return (
    <div class={`code-editor is-${state.value}`}>
      <div class="code-editor-host" ref={host}>
        {state.value === "loading" && <p class="soft">The editor is being loaded …</p>}
      </div>
      {state.value === "failed" && <PlainText label={label} text={text} typed={(typed) => draft.type(typed)} />}
      <p class="code-editor-place">
        <span class="mono soft">
          {line}:{column}
        </span>{" "}
        {meaning}
        <span id={hintId} class="soft" hidden={meaning !== ""}>
          <kbd>Ctrl-Space</kbd> what may stand here, <kbd>F8</kbd> next problem, <kbd>Ctrl-F</kbd> search, <kbd>Esc</kbd> <kbd>Tab</kbd> leave
        </span>
      </p>
    </div>
  );
}

/** The text without an editor, as of a page whose parts are gone. */
function PlainText({ label, text, typed }: { label: string; text: string; typed(text: string): void }) {
  return <textarea class="mono" aria-label={label} spellcheck={false} wrap="off" value={text} onInput={(event) => typed(event.currentTarget.value)} />;
}
