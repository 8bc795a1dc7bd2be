/** Times of a board's commands, from DC1 to DC2 of soft_ops. */

import type { Operation } from "./board_link";

const KEPT = 200;

export interface CommandTime {
  readonly number: number;
  readonly begun_ms: number;
  /** Undefined while it runs. */
  readonly duration_ms: number | undefined;
  /** What ran: a row, or the line that was sent; "" if unknown. */
  readonly what: string;
}

/** Add a signal to the list; an end without a start is left out. */
export function withOperation(times: readonly CommandTime[], operation: Operation, what: string): readonly CommandTime[] {
  const last = times.at(-1);
  if (operation.kind === "begins") {
    const number = (last?.number ?? 0) + 1;
    return [...times, { number, begun_ms: operation.at_ms, duration_ms: undefined, what }].slice(-KEPT);
  }
  if (!last || last.duration_ms !== undefined) return times;
  const ended = { ...last, duration_ms: operation.at_ms - last.begun_ms };
  return [...times.slice(0, -1), ended];
}

/** Note what the command is that runs now. */
export function withName(times: readonly CommandTime[], what: string): readonly CommandTime[] {
  const last = times.at(-1);
  if (!last || last.duration_ms !== undefined || last.what === what) return times;
  return [...times.slice(0, -1), { ...last, what }];
}

export function isRunning(times: readonly CommandTime[]): boolean {
  const last = times.at(-1);
  return last !== undefined && last.duration_ms === undefined;
}
