/** What was typed for a board and is not in it: rows that were not sent, texts of cells that are no numbers, one-shots.
 * It outlives the page. */

import { Kept, KeptForms } from "../../kept";
import { ONE_SHOTS } from "./oneshot_file";
import { newQueue, unsent, type QueueState } from "./queue_model";
import { ROWS, seedRow, WORD, type QueueRow } from "./queue_row";

/** The rows of the editor, and what the board had when they were edited. */
type KeptQueue = Pick<QueueState, "rows" | "steps_per_rev"> & { board: readonly QueueRow[] };

export interface OneShots {
  readonly lines: readonly string[];
  /** True: they are as in a file. */
  readonly isSaved: boolean;
}

/** Text of a cell that could not be taken. `was`: what the cell shows without it; it is no text for another value. */
export interface CellText {
  readonly text: string;
  readonly was: string;
}

const MOST_CELL_CHARACTERS = 200;
const MOST_LINE_CHARACTERS = 2000;

/** What is typed into the boxes beside the queue, by port. */
export const boardForms = new KeptForms("companion.forms");

export class KeptBoard {
  readonly oneShots: Kept<OneShots>;
  /** By place, as `3.rpm`. */
  readonly cells: Kept<Readonly<Record<string, CellText>>>;
  private readonly queue: Kept<KeptQueue | null>;

  constructor(port: string) {
    this.queue = new Kept(`companion.${port}.queue`, () => null, readQueue);
    this.oneShots = new Kept(`companion.${port}.oneshots`, () => ({ lines: Array.from({ length: ONE_SHOTS }, () => ""), isSaved: true }), readOneShots);
    this.cells = new Kept(`companion.${port}.cells`, () => ({}), readCells);
  }

  /** The queue as it was left with rows that were not sent; undefined: all were. */
  left(): QueueState | undefined {
    const kept = this.queue.peek();
    return kept ? { ...newQueue(kept.steps_per_rev), ...kept } : undefined;
  }

  /** Keep the queue while rows of it are not sent. */
  keep({ rows, board, steps_per_rev }: QueueState): void {
    const isSent = board === undefined || unsent({ ...newQueue(), rows, board }).length === 0;
    if (!isSent) this.queue.value = { rows, board, steps_per_rev };
    else if (this.queue.peek()) this.queue.value = null;
  }

  /** Keep the text of a cell that cannot be taken; null: there is none any more. */
  putCell(at: string, cell: CellText | null): void {
    const { [at]: before, ...others } = this.cells.peek();
    if (cell) this.cells.value = { ...others, [at]: { ...cell, text: cell.text.slice(0, MOST_CELL_CHARACTERS) } };
    else if (before) this.cells.value = others;
  }
}

export function readQueue(raw: unknown): KeptQueue | null | undefined {
  if (raw === null) return null;
  const { rows, board, steps_per_rev } = raw as Partial<KeptQueue>;
  if (!areRows(rows) || !areRows(board) || !isCount(steps_per_rev) || steps_per_rev < 1) return undefined;
  return { rows, board, steps_per_rev };
}

const SEED = seedRow(1);
const KEYS = Object.keys(SEED) as (keyof QueueRow)[];

function areRows(raw: unknown): raw is readonly QueueRow[] {
  return Array.isArray(raw) && raw.length === ROWS && raw.every(isRow);
}

function isRow(raw: unknown): boolean {
  if (typeof raw !== "object" || raw === null) return false;
  const row = raw as Record<string, unknown>;
  return Object.keys(row).length === KEYS.length && KEYS.every((key) => (typeof SEED[key] === "boolean" ? typeof row[key] === "boolean" : isCount(row[key])));
}

function isCount(raw: unknown): raw is number {
  return typeof raw === "number" && Number.isInteger(raw) && raw >= 0 && raw < WORD;
}

export function readOneShots(raw: unknown): OneShots | undefined {
  const { lines, isSaved } = (raw ?? {}) as Partial<OneShots>;
  if (!Array.isArray(lines) || lines.length !== ONE_SHOTS) return undefined;
  const areLines = lines.every((line) => typeof line === "string" && line.length <= MOST_LINE_CHARACTERS);
  return areLines ? { lines: lines as string[], isSaved: isSaved === true } : undefined;
}

export function readCells(raw: unknown): Readonly<Record<string, CellText>> | undefined {
  if (typeof raw !== "object" || raw === null) return undefined;
  const isCell = (cell: unknown) => typeof (cell as CellText | null)?.text === "string" && typeof (cell as CellText).was === "string";
  return Object.fromEntries(Object.entries(raw).filter(([, cell]) => isCell(cell)));
}
