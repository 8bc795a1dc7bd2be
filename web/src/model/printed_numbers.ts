/** Numbers in the lines that a board prints, by the rules of the Arduino IDE's plotter and of `hil sketch plot`: with
 * commas, spaces or tabs between, each with a name and a colon before it or without. Pure. */

import type { Piece } from "./port_record";

const ITEM = /(?:([^\s,:]+):[ \t]*)?([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)(?:[\s,]+|$)/y;
const MOST_LINE_BYTES = 1024;
export const MOST_NAMES = 16;
const MOST_ROWS = 20_000;
/** So many of the oldest go at a time. */
const DROPPED_ROWS = 2_000;
const NEW_LINE = 0x0a;

/** Numbers of a line by their names; one without a name is called by its place in the line, from 1 on. Empty: the line has
 * something else, too. */
export function numbersIn(line: string): Map<string, number> {
  const found = new Map<string, number>();
  const text = line.trim();
  let at = 0;
  while (at < text.length) {
    ITEM.lastIndex = at;
    const item = ITEM.exec(text);
    if (!item) return new Map();
    found.set(item[1] || String(found.size + 1), Number(item[2]));
    at = ITEM.lastIndex;
  }
  return found;
}

/** Series of the numbers that come, from the first whole line on. */
export class PrintedNumbers {
  readonly names: string[] = [];
  /** Simulated times of the lines. */
  readonly times_s: number[] = [];
  /** The latest value of each name at each line; NaN before the first. */
  readonly columns: number[][] = [];
  /** Lines that have something else. */
  others = 0;
  private held: number[] = [];
  private isWhole = false;
  private readonly decoder = new TextDecoder();

  add({ at_s, bytes, isSent }: Piece): void {
    if (isSent) return;
    for (const byte of bytes) {
      if (byte !== NEW_LINE) {
        this.held.push(byte);
        continue;
      }
      if (this.isWhole) this.addLine(at_s, this.decoder.decode(Uint8Array.from(this.held)));
      this.held = [];
      this.isWhole = true;
    }
    if (this.held.length > MOST_LINE_BYTES) {
      this.held = [];
      this.isWhole = false;
    }
  }

  private addLine(at_s: number, line: string): void {
    const numbers = numbersIn(line);
    const added = [...numbers.keys()].filter((name) => !this.names.includes(name));
    if (!numbers.size || this.names.length + added.length > MOST_NAMES) {
      this.others += line.trim() ? 1 : 0;
      return;
    }
    for (const name of added) {
      this.names.push(name);
      this.columns.push(this.times_s.map(() => NaN));
    }
    const last = this.times_s.length - 1;
    for (const [at, column] of this.columns.entries()) column.push(numbers.get(this.names[at]!) ?? column[last] ?? NaN);
    this.times_s.push(at_s);
    if (this.times_s.length <= MOST_ROWS) return;
    for (const list of [this.times_s, ...this.columns]) list.splice(0, DROPPED_ROWS);
  }

  /** As a table of CSV. */
  csv(): string {
    const rows = this.times_s.map((at_s, row) => [at_s, ...this.columns.map((column) => (Number.isNaN(column[row]) ? "" : column[row]))].join(","));
    return `${[["at_s", ...this.names.map(quoted)].join(","), ...rows].join("\n")}\n`;
  }
}

function quoted(name: string): string {
  return /["\n]/.test(name) ? `"${name.replaceAll('"', '""')}"` : name;
}
