/** Views of what a port said: as text, with a time before each line, or as bytes in hexadecimal digits. Each makes of the
 * pieces, one after the other, what a terminal is to write. Pure. */

import type { Piece } from "./port_record";
import { plainOf, TerminalText } from "./terminal_text";

export interface TerminalView {
  /** What is written for the next piece. */
  next(piece: Piece): string;
}

export const VIEWS = { text: "Text", times: "Times", hex: "Hex", plot: "Plot" } as const;
export type ViewName = keyof typeof VIEWS;

const NEW_LINE = 0x0a;
const RETURN = "\r";

export class PlainView implements TerminalView {
  private readonly text = new TerminalText();

  next({ bytes, isSent }: Piece): string {
    return isSent ? "" : this.text.next(bytes);
  }
}

/** Format a time as a line begins with it. */
export function stampOf(at_s: number): string {
  return `${at_s.toFixed(3).padStart(9)} `;
}

/** A line has the time of its first byte; one that a return begins once more has it again. */
export class TimesView implements TerminalView {
  private readonly text = new TerminalText();
  private isNew = true;
  private isReturned = false;

  next({ at_s, bytes, isSent }: Piece): string {
    let written = "";
    if (isSent) return written;
    for (let at = 0; at < bytes.length; ) {
      const end = bytes.indexOf(NEW_LINE, at) + 1 || bytes.length;
      written += this.part(at_s, bytes.subarray(at, end));
      at = end;
    }
    return written;
  }

  private part(at_s: number, bytes: Uint8Array): string {
    const stamp = `\x1b[0;90m${stampOf(at_s)}\x1b[0m`;
    const before = stamp + this.text.style;
    const text = this.text.next(bytes);
    const returned = text.replace(/\r+(?=[^\r\n])/g, `${RETURN}${stamp}${this.text.style}`);
    const isAgain = this.isNew || (this.isReturned && !/^[\r\n]/.test(text));
    this.isNew = text.endsWith("\n");
    this.isReturned = text.endsWith(RETURN) || (this.isReturned && text === "");
    return (isAgain && text ? before : "") + returned;
  }
}

const WIDTH = 16;

/** Rows of sixteen bytes: where they begin, the bytes, and as text; rows of what was sent say so. `from`: place of the first
 * byte that the port said. */
export class HexView implements TerminalView {
  private row: number[] = [];
  private isSent = false;

  constructor(private from = 0) {}

  next({ bytes, isSent = false }: Piece): string {
    let written = isSent !== this.isSent && this.row.length ? `${RETURN}\n` : "";
    if (isSent !== this.isSent) this.beginRow();
    this.isSent = isSent;
    for (const byte of bytes) {
      this.row.push(byte);
      if (this.row.length < WIDTH) continue;
      written += `\r${this.rowText()}\r\n`;
      this.beginRow();
    }
    return this.row.length ? `${written}\r${this.rowText()}` : written;
  }

  private beginRow(): void {
    if (!this.isSent) this.from += this.row.length;
    this.row = [];
  }

  private rowText(): string {
    return hexRow(this.isSent ? "  sent" : this.from.toString(16).padStart(6, "0"), this.row);
  }
}

function hexRow(head: string, bytes: number[]): string {
  const digits = Array.from({ length: WIDTH }, (_, at) => bytes[at]?.toString(16).padStart(2, "0") ?? "  ");
  const text = bytes.map((byte) => (byte >= 0x20 && byte < 0x7f ? String.fromCharCode(byte) : ".")).join("");
  return `${head}  ${digits.slice(0, 8).join(" ")}  ${digits.slice(8).join(" ")}  ${text}`;
}

export function viewOf(name: ViewName, gone: number): TerminalView {
  if (name === "hex") return new HexView(gone);
  return name === "times" ? new TimesView() : new PlainView();
}

/** The whole as a file has it: without colours, lines end with a line feed. */
export function savedText(name: ViewName, pieces: readonly Piece[], gone: number): string {
  const view = viewOf(name, gone);
  if (name === "hex")
    return inTurns(pieces)
      .map((piece) => view.next(piece))
      .join("")
      .replaceAll(RETURN, "");
  return plainOf(pieces.map((piece) => view.next(piece)).join("")).replace(/\r+\n/g, "\n");
}

/** What was said, what was sent, and so on in turn: each as one piece. */
function inTurns(pieces: readonly Piece[]): Piece[] {
  const turns: Piece[][] = [];
  for (const piece of pieces) {
    const last = turns.at(-1);
    if (last && Boolean(last[0]!.isSent) === Boolean(piece.isSent)) last.push(piece);
    else turns.push([piece]);
  }
  return turns.map((turn) => ({ ...turn[0]!, bytes: joined(turn) }));
}

function joined(pieces: readonly Piece[]): Uint8Array {
  const all = new Uint8Array(pieces.reduce((sum, { bytes }) => sum + bytes.length, 0));
  let at = 0;
  for (const { bytes } of pieces) {
    all.set(bytes, at);
    at += bytes.length;
  }
  return all;
}
