/** One-shot files of the SAC's companion program: a command a line, 100 lines, an empty line an empty slot.
 * Source: SAC user manual, companion app; a file that it saved. */

export const ONE_SHOTS = 100;
const LINE_BYTES = 80;

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
