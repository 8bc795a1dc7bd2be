/** Texts of a board and of what was typed, kept within bounds and made harmless. */

const KEPT_CHARACTERS = 30_000;
const KEPT_LINES = 500;

/** Append what a board says; control characters are shown as `\x1b`. */
export function withIncoming(log: string, text: string): string {
  const shown = text
    .replace(/\r\n/g, "\n")
    .replace(/\r/g, "\n")
    .replace(/[^\n\t\x20-\x7e\xa0-\xff]/g, escaped);
  const all = log + shown;
  if (all.length <= KEPT_CHARACTERS) return all;
  const cut = all.slice(-KEPT_CHARACTERS);
  return cut.slice(cut.indexOf("\n") + 1);
}

function escaped(character: string): string {
  return `\\x${character.charCodeAt(0).toString(16).padStart(2, "0")}`;
}

export interface SentLine {
  readonly number: number;
  readonly at_ms: number;
  readonly line: string;
}

export function withSent(sent: readonly SentLine[], line: string, at_ms: number): readonly SentLine[] {
  return [...sent, { number: (sent.at(-1)?.number ?? 0) + 1, at_ms, line }].slice(-KEPT_LINES);
}

/** Lines of a history, the last first, each once: for the arrow keys. */
export function recalled(sent: readonly SentLine[]): string[] {
  return [...new Set(sent.map(({ line }) => line).reverse())];
}
