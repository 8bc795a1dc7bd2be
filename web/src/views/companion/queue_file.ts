/** Queue files of the SAC's companion program: 30 rows of twelve numbers, each between blanks, with commas
 * between; lines end CR LF; a fraction under 1 has no zero before its point.
 * Source: SAC user manual, companion app; files that it saved. */

import { FileRefusal, fileLines, type FileProblem } from "./file_problem";
import { decimal, ROWS, WORD, type QueueRow } from "./queue_row";

export const COLUMNS = ["position", "steps", "direction", "full step", "RPM", "cycle", "ramp", "acc", "dec", "u", "sync", "deltaT"] as const;
const LARGEST = [ROWS, WORD - 1, 1, 1, WORD - 1, WORD - 1, 1, 99900, 99900, 255, 1, WORD - 1];
const HUNDREDTHS = new Set([7, 8]);
const NUMBER = /^(\d*\.?\d+|\d+\.)$/;

/** Content of a file: rows by position, and the line of each. */
export interface QueueFile {
  readonly rows: readonly QueueRow[];
  readonly lines: readonly number[];
}

/** Read the 30 rows of a queue file. Blanks may be missing, lines may end LF.
 * Throws FileRefusal: something is wrong; it says all of it. */
export function readQueue(data: Uint8Array, file: string): QueueFile {
  const { lines, isWhole } = fileLines(data, file);
  const problems: FileProblem[] = [];
  const rows = new Map<number, [QueueRow, number]>();
  lines.forEach((text, index) => {
    const line = index + 1;
    const tell = (column: number, text: string) => problems.push({ file, line, column, text });
    if (!text.trim()) {
      if (line < lines.length) tell(1, "an empty line; take it out");
      return;
    }
    if (line === lines.length && !isWhole && isCut(text)) {
      tell(text.length + 1, "the file ends in the middle of this row; it was cut off, copy it again");
      return;
    }
    const read = readRow(text, tell);
    if (!read) return;
    const [position, row] = read;
    if (rows.has(position)) tell(1, `position ${position} stands twice; a queue has each once`);
    rows.set(position, [row, line]);
  });
  const all = Array.from({ length: ROWS }, (_, index) => index + 1);
  const missing = all.filter((position) => !rows.has(position));
  if (missing.length && !problems.length) {
    const text = `no row for position ${missing.join(", ")}; a queue has ${ROWS}`;
    problems.push({ file, line: Math.max(lines.length, 1), column: 1, text });
  }
  if (problems.length) throw new FileRefusal(problems);
  const inOrder = all.map((position) => rows.get(position)!);
  return { rows: inOrder.map(([row]) => row), lines: inOrder.map(([, line]) => line) };
}

/** True if a line without an end stops within its row: numbers are missing, or the blank that follows each. */
function isCut(text: string): boolean {
  const cells = text.split(",");
  if (!/^[\d\s.,]+$/.test(text) || cells.length > COLUMNS.length) return false;
  return cells.length < COLUMNS.length || (text.startsWith(" ") && !text.endsWith(" "));
}

type Tell = (column: number, text: string) => void;

/** Read a line of the file, as a position and its row; undefined: it was told what is wrong. */
export function readRow(text: string, tell: Tell): [number, QueueRow] | undefined {
  const cells = text.split(",");
  if (cells.length !== COLUMNS.length) {
    tell(1, `${cells.length} numbers; a row has ${COLUMNS.length}: ${COLUMNS.join(", ")}`);
    return undefined;
  }
  let isGood = true;
  let column = 1;
  const numbers = cells.map((cell, index) => {
    const at = column + cell.length - cell.trimStart().length;
    column += cell.length + 1;
    const value = readNumber(cell.trim(), index);
    if (typeof value === "number") return value;
    tell(at, value);
    isGood = false;
    return 0;
  });
  if (!isGood) return undefined;
  const [position, steps, ccw, full, rpm, cycle_us, linear, acc, dec, extra, sync, wait_us] = numbers as [
    number,
    number,
    number,
    number,
    number,
    number,
    number,
    number,
    number,
    number,
    number,
    number,
  ];
  if (position < 1) tell(1, `position 0 is not of the queue; positions are 1 to ${ROWS}`);
  else if (rpm === 0 || cycle_us === 0) tell(1, "RPM and cycle cannot be 0");
  else if (steps === 0) tell(1, "no steps; a queue holds no continuous motion");
  else {
    return [
      position,
      {
        steps,
        is_ccw: ccw === 1,
        is_full: full === 1,
        rpm,
        cycle_us,
        is_linear: linear === 1,
        acc_hundredths: acc,
        dec_hundredths: dec,
        extra_pulses: extra,
        is_sync: sync === 1,
        wait_us,
      },
    ];
  }
  return undefined;
}

/** Read a number of a column; a text says what is wrong with it. */
export function readNumber(text: string, column: number): number | string {
  const name = COLUMNS[column]!;
  const largest = LARGEST[column]!;
  const isHundredths = HUNDREDTHS.has(column);
  if (!NUMBER.test(text) || text.length > 12 || (text.includes(".") && !isHundredths)) {
    return `${name} is "${text.slice(0, 20)}"; write a ${isHundredths ? "" : "whole "}number`;
  }
  const [whole = "", decimals = ""] = text.split(".");
  const significant = decimals.replace(/0+$/, "");
  let value = Number(whole);
  if (isHundredths) {
    if (significant.length > 2 || (value >= 100 && significant)) {
      return `${name} is ${text}; a board keeps two decimals below 100, and none from there on`;
    }
    value = value * 100 + Number(decimals.padEnd(2, "0").slice(0, 2));
  }
  if (value > largest) return `${name} is ${text}; ${isHundredths ? largest / 100 : largest} is the largest`;
  return value;
}

/** Write a row's line as the companion does, without its end. */
export function writeRow(position: number, row: QueueRow): string {
  const numbers = [
    position,
    row.steps,
    Number(row.is_ccw),
    Number(row.is_full),
    row.rpm,
    row.cycle_us,
    Number(row.is_linear),
    decimal(row.acc_hundredths),
    decimal(row.dec_hundredths),
    row.extra_pulses,
    Number(row.is_sync),
    row.wait_us,
  ];
  return numbers.map((number) => ` ${number} `).join(",");
}

/** Write a queue's file as the companion does. */
export function writeQueue(rows: readonly QueueRow[]): Uint8Array {
  return new TextEncoder().encode(rows.map((row, index) => `${writeRow(index + 1, row)}\r\n`).join(""));
}
