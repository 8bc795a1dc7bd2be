/** An editor of CodeMirror for one text. It is loaded when the first one is opened. */

import { autocompletion, completionKeymap } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap, indentWithTab, isolateHistory } from "@codemirror/commands";
import { bracketMatching, foldGutter, foldKeymap, indentOnInput, syntaxHighlighting } from "@codemirror/language";
import { type Diagnostic, forEachDiagnostic, lintGutter, lintKeymap, setDiagnostics } from "@codemirror/lint";
import { highlightSelectionMatches, search, searchKeymap } from "@codemirror/search";
import { Compartment, EditorState, type Extension, Prec, RangeSet, StateEffect, StateField, type Text } from "@codemirror/state";
import {
  Decoration,
  drawSelection,
  EditorView,
  GutterMarker,
  gutterLineClass,
  highlightActiveLine,
  highlightActiveLineGutter,
  keymap,
  lineNumbers,
} from "@codemirror/view";
import { classHighlighter } from "@lezer/highlight";
import type { DocumentProblem } from "../../model/problems";
import { withSheets } from "../strict_styles";
import type { EditorOptions, TextLanguage } from "./editor_options";
import { gcodeSupport } from "./gcode_support";
import { yamlSupport } from "./yaml_support";

/** More problems than these are listed, and not drawn. */
const MOST_DRAWN = 1000;

/** States of editors that are closed, with what can be undone, by their keys. */
const closed = new Map<string, EditorState>();

const setMark = StateEffect.define<number>();
const markClass = Decoration.line({ class: "is-now" });

class MarkedGutter extends GutterMarker {
  override elementClass = "is-now";
}
const markedGutter = new MarkedGutter();

/** Line that is carried out; 0: none is. */
const markedLine = StateField.define<number>({
  create: () => 0,
  update: (line, transaction) => transaction.effects.reduce((now, effect) => (effect.is(setMark) ? effect.value : now), line),
  provide: (field) => [
    EditorView.decorations.from(field, (line) => (view) => {
      const at = beginOf(view.state.doc, line);
      return at === null ? Decoration.none : Decoration.set([markClass.range(at)]);
    }),
    gutterLineClass.compute([field, "doc"], (state) => {
      const at = beginOf(state.doc, state.field(field));
      return at === null ? RangeSet.empty : RangeSet.of([markedGutter.range(at)]);
    }),
  ],
});

function beginOf(doc: Text, line: number): number | null {
  return line >= 1 && line <= doc.lines ? doc.line(line).from : null;
}

/** Escape lets the next Tab leave the text, until something is typed. */
const escapeLeaves: Extension = [
  Prec.highest(
    keymap.of([
      {
        key: "Escape",
        run: (view) => {
          view.setTabFocusMode(true);
          return false;
        },
      },
    ]),
  ),
  EditorView.updateListener.of((update) => {
    if (update.docChanged || (update.focusChanged && update.view.hasFocus)) update.view.setTabFocusMode(false);
  }),
];

/** What depends on who shows the text: another view of it has its own. */
const outside = new Compartment();

const always: Extension = [
  lineNumbers(),
  foldGutter(),
  lintGutter(),
  history(),
  drawSelection(),
  indentOnInput(),
  bracketMatching(),
  highlightActiveLine(),
  highlightActiveLineGutter(),
  highlightSelectionMatches(),
  search({ top: true }),
  syntaxHighlighting(classHighlighter),
  markedLine,
  escapeLeaves,
  keymap.of([...completionKeymap, ...searchKeymap, ...lintKeymap, ...foldKeymap, ...historyKeymap, indentWithTab, ...defaultKeymap]),
];

function supportOf(language: TextLanguage): Extension {
  return language.kind === "gcode" ? gcodeSupport() : yamlSupport(language.kind, () => language.devices());
}

export class CodeEditor {
  private readonly view: EditorView;
  private text: string;

  /** `key`: editors of the same one go on where the last one was closed. */
  constructor(
    parent: HTMLElement,
    private readonly key: string,
    text: string,
    private readonly options: EditorOptions,
  ) {
    const before = closed.get(key);
    let view!: EditorView;
    withSheets(() => {
      view = new EditorView({ parent, state: before ?? EditorState.create({ doc: text, extensions: [always, outside.of([])] }) });
    });
    this.view = view;
    this.text = before ? before.doc.toString() : text;
    view.dispatch({ effects: outside.reconfigure(this.connections()) });
    this.setText(text);
  }

  private connections(): Extension {
    const { options } = this;
    return [
      supportOf(options.language),
      autocompletion({ icons: false }),
      EditorView.contentAttributes.of({ "aria-label": options.label, "aria-describedby": options.hintId, spellcheck: "false", tabindex: "0" }),
      EditorView.contentAttributes.of((view) => ({ "aria-invalid": String(hasProblems(view.state)) })),
      EditorView.updateListener.of((update) => {
        if (update.docChanged) {
          const text = update.state.doc.toString();
          if (text !== this.text) options.typed((this.text = text));
        }
        if (update.focusChanged) options.focused(update.view.hasFocus);
        if (update.docChanged || update.selectionSet) this.tellPlace();
      }),
      EditorView.domEventHandlers({
        drop: (event) => {
          const file = event.dataTransfer?.files[0];
          if (!file) return false;
          event.preventDefault();
          options.dropped(file);
          return true;
        },
      }),
    ];
  }

  private tellPlace(): void {
    const { state } = this.view;
    const { head } = state.selection.main;
    const line = state.doc.lineAt(head);
    const [meaning] = state.languageDataAt<(state: EditorState, at: number) => string>("meaningAt", head);
    this.options.moved({ line: line.number, column: head - line.from + 1, meaning: meaning?.(state, head) ?? "" });
  }

  /** Show another text, by a change that can be undone. */
  setText(text: string): void {
    if (text === this.text) return;
    const now = this.view.state.doc.toString();
    const next = text.replace(/\r\n?/g, "\n");
    this.text = text;
    if (now === next) return;
    let from = 0;
    const shorter = Math.min(now.length, next.length);
    while (from < shorter && now[from] === next[from]) from++;
    let same = 0;
    while (same < shorter - from && now[now.length - 1 - same] === next[next.length - 1 - same]) same++;
    this.view.dispatch({
      changes: { from, to: now.length - same, insert: next.slice(from, next.length - same) },
      annotations: isolateHistory.of("full"),
    });
  }

  setProblems(problems: readonly DocumentProblem[]): void {
    const { state } = this.view;
    const placed = problems.filter(({ line }) => line >= 1 && line <= state.doc.lines).slice(0, MOST_DRAWN);
    this.view.dispatch(
      setDiagnostics(
        state,
        placed.map((problem) => diagnostic(state.doc, problem)),
      ),
    );
  }

  /** Mark the line that is carried out, and keep it in sight; 0: none is. */
  mark(line: number): void {
    const { state } = this.view;
    if (state.field(markedLine) === line) return;
    const at = beginOf(state.doc, line);
    const isAway = at !== null && !this.view.hasFocus && !this.view.visibleRanges.some(({ from, to }) => from <= at && at <= to);
    this.view.dispatch({ effects: isAway ? [setMark.of(line), EditorView.scrollIntoView(at, { y: "center" })] : setMark.of(line) });
  }

  /** Put the cursor to a place of the text. */
  goTo(line: number, column: number): void {
    const { doc } = this.view.state;
    const there = doc.line(Math.min(Math.max(line, 1), doc.lines));
    const anchor = Math.min(there.from + Math.max(column - 1, 0), there.to);
    this.view.dispatch({ selection: { anchor }, effects: EditorView.scrollIntoView(anchor, { y: "center" }) });
    this.view.focus();
  }

  close(): void {
    closed.set(this.key, this.view.state);
    this.view.destroy();
  }
}

function hasProblems(state: EditorState): boolean {
  let has = false;
  forEachDiagnostic(state, () => (has = true));
  return has;
}

/** A problem stands at the word that it is at. */
function diagnostic(doc: Text, { line, column, text }: DocumentProblem): Diagnostic {
  const there = doc.line(line);
  const from = Math.min(there.from + Math.max(column - 1, 0), there.to);
  const word = /^(\w+|\S)/.exec(there.text.slice(from - there.from, from - there.from + 200))?.[0] ?? "";
  return { from, to: from + word.length, severity: "error", message: text };
}
