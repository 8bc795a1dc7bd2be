/** Words of a line of G-code, for colours and for what they mean. Pure. */

import { CODE_FUNCTIONS, CODE_LETTERS, CODE_WORDS, type CodeWord } from "./document_words";

export type CodeKind = "command" | "refused" | "axis" | "word" | "comment" | "parameter" | "function" | "number" | "operator" | "other";

export interface CodeToken {
  from: number;
  to: number;
  kind: CodeKind;
  /** What it is known by, as G1 or X; empty: it has no meaning of its own. */
  name: string;
}

const WORDS: ReadonlyMap<string, CodeWord> = new Map([...CODE_WORDS, ...CODE_LETTERS].map((word) => [word.name, word]));
const FUNCTIONS: ReadonlyMap<string, CodeWord> = new Map(CODE_FUNCTIONS.map((each) => [each.name, each]));
const FORMS: readonly [RegExp, CodeKind][] = [
  [/\([^)]*\)?|;.*/y, "comment"],
  [/#\s*(<[^>]*>?|\d+)/y, "parameter"],
  [/(?:MOD|AND|XOR|OR|EQ|NE|GT|GE|LT|LE)(?![A-Z<])|\*\*|[-+*/=]/iy, "operator"],
  [new RegExp(`(?:${CODE_FUNCTIONS.map(({ name }) => name).join("|")})(?=\\s*\\[)`, "iy"), "function"],
  [/[GM]\s*[-+]?\d*\.?\d*/iy, "command"],
  [/[XYZABCUVW]\s*[-+]?\d*\.?\d*/iy, "axis"],
  [/[A-Z]\s*[-+]?\d*\.?\d*/iy, "word"],
  [/\d+\.?\d*|\.\d+/y, "number"],
];

/** The token of a line at a place: blanks are one, too. */
export function tokenAt(line: string, from: number): CodeToken {
  const blank = /\s+/y;
  blank.lastIndex = from;
  if (blank.test(line)) return { from, to: blank.lastIndex, kind: "other", name: "" };
  for (const [form, kind] of FORMS) {
    form.lastIndex = from;
    const found = form.exec(line)?.[0].trimEnd();
    if (!found) continue;
    const token = { from, to: from + found.length };
    if (kind === "command") {
      const name = commandName(found);
      return { ...token, name, kind: WORDS.get(name)?.use === "refused" ? "refused" : "command" };
    }
    if (kind === "axis" || kind === "word") {
      const name = found[0]!.toUpperCase();
      return { ...token, name, kind: WORDS.get(name)?.use === "refused" ? "refused" : kind };
    }
    return { ...token, kind, name: kind === "function" ? found.toUpperCase() : "" };
  }
  return { from, to: from + 1, kind: "other", name: "" };
}

/** G01 is G1, G38.20 is G38.2. */
function commandName(text: string): string {
  const number = text.slice(1).trim();
  return text[0]!.toUpperCase() + (number === "" ? "" : String(Number(number)));
}

/** Meaning of what stands at a column of a line; null: it has none. */
export function explainedAt(line: string, column: number): { from: number; to: number; text: string } | null {
  for (let from = 0; from < line.length && from <= column; ) {
    const token = tokenAt(line, from);
    if (column >= token.from && column < token.to) {
      const text = meaningOf(token);
      return text ? { from: token.from, to: token.to, text } : null;
    }
    from = token.to;
  }
  return null;
}

function meaningOf({ name, kind }: CodeToken): string {
  if (kind === "comment") return "comment: nothing is done";
  if (kind === "parameter") return "parameter: a number that the program keeps";
  const word = FUNCTIONS.get(name) ?? WORDS.get(name);
  if (!word) return name && kind === "command" ? `${name}: there is no such word here` : "";
  const group = word.group && word.group !== "no group" ? ` (${word.group})` : "";
  const done = word.use === "accepted" ? "; nothing to do here" : word.use === "refused" && word.group ? "; refused here" : "";
  return `${name}: ${word.meaning}${group}${done}${word.remedy ? `: ${word.remedy}` : ""}`;
}

/** Words that may be written, with their meanings. */
export function codeOffers(): { name: string; detail: string; about: string }[] {
  return CODE_WORDS.filter((word) => word.use !== "refused").map((word) => ({ name: word.name, detail: word.group ?? "", about: word.meaning }));
}
