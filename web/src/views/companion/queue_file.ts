/** Queue files of the SAC's companion program, as it writes them: 30 rows of twelve numbers, each between blanks,
 * with commas between; lines end CR LF; a fraction under 1 has no zero before its point.
 * Source: SAC user manual, companion app; files that it saved. */

import { decimal, type QueueRow } from "./queue_row";

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
