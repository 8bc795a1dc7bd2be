/** Lines that are sent to a port: what ends them, what was sent before, and macros, whose texts have buttons. Pure. */

export const ENDINGS = { none: "", LF: "\n", CR: "\r", "CR LF": "\r\n" } as const;
export type Ending = keyof typeof ENDINGS;
export const ENDING_NAMES = Object.keys(ENDINGS) as Ending[];

const MOST_LINES = 100;
const MOST_MACROS = 50;
const MOST_NAME = 40;
const MOST_TEXT = 4000;

/** Lines that were sent, with one more; one that was sent before moves to the end. */
export function withLine(lines: readonly string[], line: string): string[] {
  return line === "" ? [...lines] : [...lines.filter((each) => each !== line), line].slice(-MOST_LINES);
}

export interface Macro {
  name: string;
  /** What is sent; `\r`, `\n`, `\t`, `\\` and `\xHH` stand for bytes. */
  text: string;
  ending: Ending;
}

export const NEW_MACRO: Macro = { name: "", text: "", ending: "CR" };

/** Read macros that were kept; what is none is left out. */
export function readMacros(raw: unknown): Macro[] {
  if (!Array.isArray(raw)) return [];
  return (raw as unknown[])
    .map(readMacro)
    .filter((macro) => macro !== null)
    .slice(0, MOST_MACROS);
}

function readMacro(raw: unknown): Macro | null {
  const { name, text, ending } = (raw ?? {}) as Partial<Record<keyof Macro, unknown>>;
  if (typeof name !== "string" || typeof text !== "string") return null;
  const known = ENDING_NAMES.find((each) => each === ending) ?? NEW_MACRO.ending;
  return { name: name.slice(0, MOST_NAME), text: text.slice(0, MOST_TEXT), ending: known };
}

/** Name that stands on a macro's button. */
export function titleOf({ name, text }: Macro): string {
  return name.trim() || text.trim().slice(0, MOST_NAME) || "empty";
}

/** The list with one of its items moved; past its ends it stays. */
export function moved<T>(list: readonly T[], from: number, by: number): T[] {
  const to = from + by;
  if (to < 0 || to >= list.length) return [...list];
  const next = [...list];
  next.splice(to, 0, ...next.splice(from, 1));
  return next;
}

const ESCAPES: Record<string, number> = { r: 0x0d, n: 0x0a, t: 0x09, "\\": 0x5c, "0": 0, e: 0x1b };
const ESCAPED = /\\(x[0-9a-fA-F]{2}|[rnt\\0e])/g;

/** Bytes of a macro's text with its end. An escape that there is none of stands for itself. */
export function bytesOfMacro({ text, ending }: Macro): Uint8Array {
  const encoder = new TextEncoder();
  const bytes: number[] = [];
  let at = 0;
  for (const found of text.matchAll(ESCAPED)) {
    bytes.push(...encoder.encode(text.slice(at, found.index)));
    const what = found[1]!;
    bytes.push(what.length === 3 ? parseInt(what.slice(1), 16) : ESCAPES[what]!);
    at = found.index + found[0].length;
  }
  bytes.push(...encoder.encode(text.slice(at) + ENDINGS[ending]));
  return Uint8Array.from(bytes);
}
