/** Screens of a SAC that its companion reads: the queue's listing, the configuration, the session.
 * Source: SAC user manual, queue, configure; `q`, `cc` and `cf` at the prompt. */

import { ROWS, type QueueRow } from "./queue_row";

const ROW = /^(\d+)\t(\d+)\t([ +])(CW|CCW)\t(\d+)\t(\d+)\t([ *])([\d.]+)\t([\d.]+)\t(\d+)\t(s?) +(\d+)$/;
const PLACE = /^Q is at (\d+)/;

/** Listing of a queue; `at`: the running row, or else where the next command goes. */
export interface Listing {
  readonly rows: readonly QueueRow[];
  readonly at: number;
}

/** Read the lines of `q`; a text says why they are none. */
export function readListing(lines: readonly string[]): Listing | string {
  const rows: QueueRow[] = [];
  let at = 0;
  for (const line of lines) {
    const match = ROW.exec(line);
    if (match) {
      const position = Number(match[1]);
      if (position === 0) continue; // debug lists the continuous command too
      if (position !== rows.length + 1) return `row ${rows.length + 1} is missing in the listing`;
      rows.push(listedRow(match));
    }
    at = Number(PLACE.exec(line)?.[1] ?? at);
  }
  if (rows.length !== ROWS) return `the listing has ${rows.length} rows that can be read, not ${ROWS}`;
  if (!at) return "the listing does not say where the queue is";
  return { rows, at };
}

function listedRow(match: RegExpExecArray): QueueRow {
  const [, , steps, pulses, direction, rpm, cycle_us, ramp, acc, dec, extra, sync, wait_us] = match;
  return {
    steps: Number(steps),
    is_ccw: direction === "CCW",
    is_full: pulses === " ",
    rpm: Number(rpm),
    cycle_us: Number(cycle_us),
    is_linear: ramp === "*",
    acc_hundredths: Math.round(Number(acc) * 100),
    dec_hundredths: Math.round(Number(dec) * 100),
    extra_pulses: Number(extra),
    is_sync: sync === "s",
    wait_us: Number(wait_us),
  };
}

/** Values of the configure screen that the companion needs. */
export interface Configuration {
  readonly steps_per_rev: number;
  readonly microstep_exponent: number;
  readonly interrupt_overhead_us: number;
  readonly clock_correction_us: number;
  readonly slow_rpm: number;
  readonly is_network_swapped: boolean;
}

/** Read the lines of `cc`; undefined: they are no SAC's. */
export function readConfiguration(lines: readonly string[]): Configuration | undefined {
  const screen = lines.join("\n");
  const value = (name: RegExp) => Number(name.exec(screen)?.[1] ?? NaN);
  const found = {
    steps_per_rev: value(/a sprf\s+(\d+)/),
    microstep_exponent: value(/J ustep\s+(\d+)/),
    interrupt_overhead_us: value(/H ihd\s+(\d+)/),
    clock_correction_us: value(/I xclk\s+(\d+)/),
    slow_rpm: value(/L slow\s+(\d+)/),
  };
  if (Object.values(found).some(Number.isNaN) || found.steps_per_rev < 1) return undefined;
  return { ...found, is_network_swapped: value(/E network\s+(\d+)/) === 1 };
}

/** Session's defaults and flags of `cf`, by their names. */
export function readSession(lines: readonly string[]): ReadonlyMap<string, string> {
  return new Map(lines.filter((line) => line.includes("\t")).map((line) => line.split("\t", 2) as [string, string]));
}

/** Speed of now of `vd`; undefined: it is none. */
export function readSpeed(lines: readonly string[]): { rpm: number; period_us: number } | undefined {
  const match = /^(\d+)\t(\d+)$/.exec(lines[0] ?? "");
  return match ? { rpm: Number(match[1]), period_us: Number(match[2]) } : undefined;
}
