/** One-shot files of the SAC's companion program: a command a line, 100 lines, an empty line an empty slot.
 * Source: SAC user manual, companion app; a file that it saved. */

import { FileRefusal, fileLines, type FileProblem } from "./file_problem";

export const ONE_SHOTS = 100;
export const LINE_BYTES = 80;

/** Read a one-shot file: 100 commands, "" for an empty slot. Missing lines at the end are empty slots.
 * Throws FileRefusal: a line is none that a board takes, or the file was cut off. */
export function readOneShots(data: Uint8Array, file: string): string[] {
  const { lines, isWhole } = fileLines(data, file);
  const problems: FileProblem[] = [];
  lines.forEach((text, index) => {
    const line = index + 1;
    if (line > ONE_SHOTS && text.trim()) {
      problems.push({ file, line, column: 1, text: `a command behind the last; a file has ${ONE_SHOTS}` });
    } else if (text.length > LINE_BYTES) {
      const what = `${text.length} characters; a board takes ${LINE_BYTES} a line`;
      problems.push({ file, line, column: LINE_BYTES + 1, text: what });
    } else if (text.includes("\t")) {
      const column = text.indexOf("\t") + 1;
      problems.push({ file, line, column, text: "a TAB; a command has printable characters only" });
    }
  });
  if (!problems.length && !isWhole && lines.length < ONE_SHOTS) {
    const column = lines.at(-1)!.length + 1;
    const text = `the file ends in the middle of one-shot ${lines.length}; it was cut off, copy it again`;
    problems.push({ file, line: lines.length, column, text });
  }
  if (!lines.length) problems.push({ file, line: 1, column: 1, text: "the file is empty" });
  if (problems.length) throw new FileRefusal(problems);
  return Array.from({ length: ONE_SHOTS }, (_, index) => lines[index] ?? "");
}

/** Write a one-shot file as the companion does. */
export function writeOneShots(commands: readonly string[]): Uint8Array {
  const lines = Array.from({ length: ONE_SHOTS }, (_, index) => `${commands[index] ?? ""}\r\n`);
  return new TextEncoder().encode(lines.join(""));
}

/** Answer why a text is no line for a board, or undefined. */
export function lineFault(text: string): string | undefined {
  if (text.length > LINE_BYTES) return `${text.length} characters; a board takes ${LINE_BYTES} a line`;
  if (!/^[\x20-\x7e]*$/.test(text)) return "a board takes printable ASCII characters";
  return undefined;
}
