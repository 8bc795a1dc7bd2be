/** Documents in YAML in an editor: completion from the bench that there is, and what keys mean. */

import type { Completion, CompletionContext, CompletionResult } from "@codemirror/autocomplete";
import { yaml, yamlLanguage } from "@codemirror/lang-yaml";
import { indentService, LanguageSupport } from "@codemirror/language";
import type { EditorState } from "@codemirror/state";
import { hoverTooltip } from "@codemirror/view";
import { type DocumentKind, explained, type Offer, offersAt } from "../../model/document_guide";
import type { DeviceRow } from "../../model/door";
import { placeAtEnd } from "../../model/yaml_place";
import { meaningTooltip } from "./meaning_tooltip";

const KINDS = { key: "property", axis: "variable", value: "constant" };
const WORD = /[\w./-]*$/;

/** A new line stands below the one before, deeper where that has a key without a value. */
const indent = indentService.of((context, at) => {
  const before = context.lineAt(at, -1).text;
  return (/^\s*/.exec(before)?.[0].length ?? 0) + (/:\s*$/.test(before) ? 2 : 0);
});

export function yamlSupport(kind: DocumentKind, devices: () => Iterable<DeviceRow>): LanguageSupport {
  const complete = (context: CompletionContext): CompletionResult | null => {
    const before = context.state.sliceDoc(0, context.pos);
    const typed = WORD.exec(before)?.[0] ?? "";
    if (!typed && !context.explicit && !/[:{,-] $/.test(before)) return null;
    const options = offersAt(kind, placeAtEnd(before.slice(0, before.length - typed.length)), devices()).map(completion);
    return options.length ? { from: context.pos - typed.length, options, validFor: /^[\w./-]*$/ } : null;
  };
  const found = (state: EditorState, at: number): { from: number; to: number; text: string } | null => {
    const line = state.doc.lineAt(at);
    const from = at - (WORD.exec(line.text.slice(0, at - line.from))?.[0].length ?? 0);
    const to = at + (/^[\w./-]*/.exec(line.text.slice(at - line.from))?.[0].length ?? 0);
    if (from === to) return null;
    const text = explained(kind, placeAtEnd(state.sliceDoc(0, from)), state.sliceDoc(from, to), devices());
    return text ? { from, to, text } : null;
  };
  const hover = hoverTooltip((view, at) => {
    const there = found(view.state, at);
    return there && meaningTooltip(there.from, there.to, there.text);
  });
  const meaningAt = (state: EditorState, at: number): string => found(state, at)?.text ?? "";
  return new LanguageSupport(yaml().language, [yamlLanguage.data.of({ autocomplete: complete, meaningAt }), hover, indent]);
}

function completion(offer: Offer, rank: number): Completion {
  return {
    label: offer.name,
    type: KINDS[offer.kind],
    detail: offer.detail,
    info: offer.about,
    ...(offer.insert === undefined ? {} : { apply: offer.insert }),
    boost: -rank,
  };
}
