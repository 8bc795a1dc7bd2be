/** A program or a machine's document, with the editor of its language. */

import { keptFor } from "../../kept";
import { ProblemList } from "../../parts/editor/problem_list";
import { TextEditor } from "../../parts/editor/text_editor";
import { saveFile } from "../../parts/files";
import { notifyError } from "../../parts/notices";
import { devices } from "../../store";
import { done, drafts, focused, isUnderWay, openFile, problemsOf, type Which } from "./path_state";

const LANGUAGES = { program: { kind: "gcode" }, machine: { kind: "MachineText", devices: () => devices.peek().values() } } as const;

export function PathText({ which, title }: { which: Which; title: string }) {
  const { text, file } = drafts[which].value;
  const problems = problemsOf(which);
  const open = (file: File) => openFile(which, file).catch(notifyError);
  const choose = async (event: Event) => {
    const input = event.currentTarget as HTMLInputElement;
    const chosen = input.files?.[0];
    input.value = "";
    if (chosen) await open(chosen);
  };
  const save = () => {
    saveFile(file, new TextEncoder().encode(text));
    drafts[which].saved(text);
  };
  return (
    <section class={`card path-text is-${which}`} aria-label={title}>
      <div class="card-head">
        <h2>{title}</h2>
        <span class="mono soft file-name">{file}</span>
        <label class="button push">
          Open a file
          <input class="out-of-sight" type="file" aria-label={`Open a file: ${title}`} onChange={(event) => void choose(event)} />
        </label>
        <button type="button" aria-label={`Save to a file: ${title}`} onClick={save}>
          Save
        </button>
      </div>
      <TextEditor
        name={which}
        memory={`${keptFor.value}/${which}`}
        label={title}
        language={LANGUAGES[which]}
        draft={drafts[which]}
        problems={problems}
        lineNow={which === "program" && isUnderWay.value ? (done.value?.line ?? 0) : 0}
        focused={(isFocused) => (focused.value = isFocused ? which : null)}
        dropped={(file) => void open(file)}
      />
      <ProblemList of={which} title={`Problems of the ${which}`} problems={problems} />
    </section>
  );
}
