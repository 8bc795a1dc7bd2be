/** G-code in an editor: colours, completion, and what words mean. */

import type { CompletionContext, CompletionResult } from "@codemirror/autocomplete";
import { LanguageSupport, StreamLanguage } from "@codemirror/language";
import type { EditorState } from "@codemirror/state";
import { hoverTooltip } from "@codemirror/view";
import { type CodeKind, codeOffers, explainedAt, tokenAt } from "../../model/gcode_text";
import { meaningTooltip } from "./meaning_tooltip";

/** Names of CodeMirror's kinds of tokens. */
const TAGS: Readonly<Record<CodeKind, string | null>> = {
  command: "keyword",
  refused: "invalid",
  axis: "propertyName",
  word: "typeName",
  comment: "comment",
  parameter: "variableName",
  function: "atom",
  number: "number",
  operator: "operator",
  other: null,
};

const gcode = StreamLanguage.define<null>({
  name: "gcode",
  token(stream) {
    const { to, kind } = tokenAt(stream.string, stream.pos);
    stream.pos = to;
    return TAGS[kind];
  },
  languageData: { commentTokens: { line: ";" }, autocomplete: complete, meaningAt },
});

function complete(context: CompletionContext): CompletionResult | null {
  const word = context.matchBefore(/[GM][\d.]*/i);
  if (!word && !context.explicit) return null;
  return {
    from: word?.from ?? context.pos,
    options: codeOffers().map(({ name, detail, about }) => ({ label: name, detail: about, info: detail, type: "keyword" })),
    validFor: /^[GM][\d.]*$/i,
  };
}

function meaningAt(state: EditorState, at: number): string {
  const line = state.doc.lineAt(at);
  const column = at - line.from;
  return (explainedAt(line.text, column) ?? explainedAt(line.text, column - 1))?.text ?? "";
}

export function gcodeSupport(): LanguageSupport {
  const hover = hoverTooltip((view, at) => {
    const line = view.state.doc.lineAt(at);
    const found = explainedAt(line.text, at - line.from);
    return found && meaningTooltip(line.from + found.from, line.from + found.to, found.text);
  });
  return new LanguageSupport(gcode, hover);
}
