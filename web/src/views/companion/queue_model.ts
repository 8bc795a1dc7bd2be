/** Editor of a queue's 30 rows: pure changes, each of which can be taken back. */

import { writeRow } from "./queue_file";
import { byCycle, byRpm, MAX_ACCELERATION, MIN_CYCLE_US, ROWS, sameRow, seedRow, stepAtOneRpm_us, USUAL_STEPS_PER_REV, WORD, type QueueRow } from "./queue_row";

const UNDO_DEPTH = 100;

/** State of the editor. `board` is what the board was last seen to have: rows that differ are to be sent. */
export interface QueueState {
  readonly rows: readonly QueueRow[];
  readonly board: readonly QueueRow[] | undefined;
  readonly steps_per_rev: number;
  readonly undo: readonly (readonly QueueRow[])[];
  readonly redo: readonly (readonly QueueRow[])[];
}

export function newQueue(stepsPerRev = USUAL_STEPS_PER_REV): QueueState {
  const rows = Array.from({ length: ROWS }, () => seedRow(stepsPerRev));
  return { rows, board: undefined, steps_per_rev: stepsPerRev, undo: [], redo: [] };
}

/** Change the rows; the state before can be had back. */
export function changed(state: QueueState, rows: readonly QueueRow[]): QueueState {
  if (rows.every((row, index) => sameRow(row, state.rows[index]!))) return state;
  return { ...state, rows, undo: [...state.undo, state.rows].slice(-UNDO_DEPTH), redo: [] };
}

export function undone(state: QueueState): QueueState {
  const before = state.undo.at(-1);
  if (!before) return state;
  return { ...state, rows: before, undo: state.undo.slice(0, -1), redo: [...state.redo, state.rows] };
}

export function redone(state: QueueState): QueueState {
  const after = state.redo.at(-1);
  if (!after) return state;
  return { ...state, rows: after, redo: state.redo.slice(0, -1), undo: [...state.undo, state.rows] };
}

/** Take over what a board shows. Rows that were edited and not sent stay as they are in the editor, also where they were
 * edited before the board was seen. */
export function seenOnBoard(state: QueueState, board: readonly QueueRow[], stepsPerRev: number): QueueState {
  const known = state.board ?? newQueue(state.steps_per_rev).rows;
  const rows = state.rows.map((row, index) => {
    const isEdited = !sameRow(row, known[index]!);
    return isEdited ? row : board[index]!;
  });
  return { ...state, rows, board, steps_per_rev: stepsPerRev };
}

/** Take over what a board shows, whatever is in the editor; can be undone. */
export function replacedByBoard(state: QueueState, board: readonly QueueRow[], stepsPerRev: number): QueueState {
  return { ...changed(state, board), board, steps_per_rev: stepsPerRev };
}

/** Note that a row stands in the board as it was sent. */
export function sentToBoard(state: QueueState, position: number, row: QueueRow): QueueState {
  if (!state.board) return state;
  return { ...state, board: replaced(state.board, position, row) };
}

/** Positions of rows that the board does not have yet. */
export function unsent(state: QueueState): number[] {
  const positions = state.rows.map((_, index) => index + 1);
  return positions.filter((p) => !state.board || !sameRow(state.rows[p - 1]!, state.board[p - 1]!));
}

function replaced(rows: readonly QueueRow[], position: number, row: QueueRow): QueueRow[] {
  return rows.map((old, index) => (index === position - 1 ? row : old));
}

// ---- rows ----

export function setRow(state: QueueState, position: number, row: QueueRow): QueueState {
  return changed(state, replaced(state.rows, position, row));
}

/** Insert rows before a position; the rows behind move down, and the last ones fall out. */
export function inserted(state: QueueState, position: number, rows: readonly QueueRow[]): QueueState {
  const before = state.rows.slice(0, position - 1);
  return changed(state, [...before, ...rows, ...state.rows.slice(position - 1)].slice(0, ROWS));
}

/** Delete rows; the rows behind move up, and fresh ones follow. */
export function deleted(state: QueueState, from: number, to: number): QueueState {
  const kept = [...state.rows.slice(0, from - 1), ...state.rows.slice(to)];
  while (kept.length < ROWS) kept.push(seedRow(state.steps_per_rev));
  return changed(state, kept);
}

/** Move rows so that the first of them stands at `target`. */
export function moved(state: QueueState, from: number, to: number, target: number): QueueState {
  const taken = state.rows.slice(from - 1, to);
  const others = [...state.rows.slice(0, from - 1), ...state.rows.slice(to)];
  const at = Math.min(Math.max(target, 1), ROWS - taken.length + 1) - 1;
  return changed(state, [...others.slice(0, at), ...taken, ...others.slice(at)]);
}

/** Overwrite rows from a position on; what goes beyond the last is left out. */
export function pasted(state: QueueState, position: number, rows: readonly QueueRow[]): QueueState {
  const end = state.rows.slice(position - 1 + rows.length);
  return changed(state, [...state.rows.slice(0, position - 1), ...rows, ...end].slice(0, ROWS));
}

export function cleared(state: QueueState): QueueState {
  return changed(state, newQueue(state.steps_per_rev).rows);
}

// ---- the clipboard: lines of a queue file ----

export function copiedText(state: QueueState, from: number, to: number): string {
  const rows = state.rows.slice(from - 1, to);
  return rows.map((row, index) => `${writeRow(from + index, row)}\r\n`).join("");
}

// ---- cells ----

export type CellName = "steps" | "rpm" | "cycle_us" | "acc" | "dec" | "extra_pulses" | "wait_us";

export interface Cell {
  readonly name: CellName;
  readonly label: string;
  readonly unit: string;
  readonly about: string;
  /** Name of its column in files and refusals. */
  readonly column: string;
  readonly largest: number;
  /** True: it has two decimals. */
  readonly isDecimal: boolean;
}

const NUMBER = /^(\d*\.?\d+|\d+\.)$/;
const whole = { isDecimal: false, largest: WORD - 1 };
const ramp = { isDecimal: true, largest: MAX_ACCELERATION };

/** Cells of a row with numbers to type, in the listing's order. */
export const CELLS: readonly Cell[] = [
  { name: "steps", label: "Steps", unit: "", column: "steps", ...whole, about: "steps, below 0 counter-clockwise: 1 to 4294967295" },
  { name: "rpm", label: "RPM", unit: "rpm", column: "RPM", ...whole, about: "velocity; the cycle follows" },
  { name: "cycle_us", label: "Cycle", unit: "us", column: "cycle", ...whole, about: "period of a step at full speed, at least 2 us; RPM follow" },
  { name: "acc", label: "Acc", unit: "", column: "acc", ...ramp, about: "acceleration, 0.01 to 999; 999 and 0: no ramp" },
  { name: "dec", label: "Dec", unit: "", column: "dec", ...ramp, about: "deceleration, 0.01 to 999; 999 and 0: no ramp, on into the next row" },
  { name: "extra_pulses", label: "usteps", unit: "", column: "u", ...whole, largest: 255, about: "pulses added to the cruise, 0 to 255" },
  { name: "wait_us", label: "deltaT", unit: "us", column: "deltaT", ...whole, about: "wait before the start, 0 to 4294967295 us" },
];
const CELL_BY_NAME = new Map(CELLS.map((cell) => [cell.name, cell]));

export function cellText(row: QueueRow, name: CellName): string {
  switch (name) {
    case "steps":
      return `${row.is_ccw ? "-" : ""}${row.steps}`;
    case "acc":
      return shown(row.acc_hundredths);
    case "dec":
      return shown(row.dec_hundredths);
    default:
      return String(row[name]);
  }
}

function shown(hundredths: number): string {
  return String(hundredths / 100);
}

/** Row with another text in a cell; a text says why it cannot be. */
export function withCell(row: QueueRow, name: CellName, text: string, stepsPerRev: number): QueueRow | string {
  const cell = CELL_BY_NAME.get(name)!;
  const typed = text.trim();
  const isBack = name === "steps" && typed.startsWith("-");
  const value = readNumber(isBack ? typed.slice(1) : typed, cell);
  if (typeof value === "string") return value;
  switch (name) {
    case "steps":
      return value < 1 ? `${cell.column} is ${typed}; a queue holds no continuous motion` : { ...row, steps: value, is_ccw: isBack };
    case "rpm":
      return withRpm(row, value, stepsPerRev);
    case "cycle_us":
      return withCycle(row, value, stepsPerRev);
    case "acc":
      return { ...row, acc_hundredths: value };
    case "dec":
      return { ...row, dec_hundredths: value };
    default:
      return { ...row, [name]: value };
  }
}

/** Number as a cell takes it, with decimals in hundredths; a text says what is wrong with it. */
function readNumber(text: string, { column, largest, isDecimal }: Cell): number | string {
  if (!NUMBER.test(text) || text.length > 12 || (text.includes(".") && !isDecimal)) {
    return `${column} is "${text.slice(0, 20)}"; write a ${isDecimal ? "" : "whole "}number`;
  }
  const [digits = "", decimals = ""] = text.split(".");
  const significant = decimals.replace(/0+$/, "");
  const value = Number(digits);
  if (significant.length > 2 || (value >= 100 && significant)) {
    return `${column} is ${text}; a board keeps two decimals below 100, and none from there on`;
  }
  const hundredths = value * 100 + Number(significant.padEnd(2, "0"));
  if (hundredths > largest * 100) return `${column} is ${text}; ${largest} is the largest`;
  return isDecimal ? hundredths : value;
}

function withRpm(row: QueueRow, rpm: number, stepsPerRev: number): QueueRow | string {
  const largest = Math.floor(stepAtOneRpm_us(stepsPerRev) / MIN_CYCLE_US);
  if (rpm < 1) return `RPM is ${rpm}; 1 is the least`;
  if (rpm > largest) return `RPM is ${rpm}; ${largest} is the most at ${stepsPerRev} steps a turn`;
  return { ...row, ...byRpm(rpm, stepsPerRev) };
}

function withCycle(row: QueueRow, cycle_us: number, stepsPerRev: number): QueueRow | string {
  if (cycle_us < MIN_CYCLE_US) return `cycle is ${cycle_us}; ${MIN_CYCLE_US} us is the least`;
  const velocity = byCycle(cycle_us, stepsPerRev);
  if (velocity.rpm < 1) return `cycle is ${cycle_us}; that is less than 1 RPM`;
  return { ...row, ...velocity };
}
