/** Calibration of a SAC's clock: it runs for a minute at a speed, and soft_ops tells when.
 * Source: SAC user manual, companion app. */

import type { Configuration } from "./board_texts";
import { stepAtOneRpm_us, WORD } from "./queue_row";

export const CALIBRATION_RPM = [5, 20, 60, 160] as const;
export const CALIBRATION_S = 60;
export const LONGEST_S = CALIBRATION_S * 1.5;
/** Start wait of a calibration, so that the start signal does not queue behind echo and prompt. */
const ECHO_US = 200_000;

/** Line that runs for a minute at a speed, from the first pulse on; a text in `refused` says why none does. */
export function calibrationLine(rpm: number, board: Configuration): { line: string } | { refused: string } {
  const cycle_us = Math.floor(stepAtOneRpm_us(board.steps_per_rev) / rpm);
  const steps = rpm * board.steps_per_rev;
  if (!(rpm >= 1) || cycle_us < 2 || steps >= WORD) {
    return { refused: `${rpm} RPM is no speed at ${board.steps_per_rev} steps a turn` };
  }
  return { line: `xm${steps}v${rpm}a999d999u0ft${ECHO_US}` };
}

export interface Calibration {
  readonly rpm: number;
  readonly nominal_ms: number;
  readonly measured_ms: number;
  /** Ratio of measured to nominal time: above 1 the board is slow. */
  readonly factor: number;
  /** What to add to each pulse, in whole microseconds. */
  readonly correction_us: number;
  /** Lines that correct it, "" if nothing is to be corrected. */
  readonly remedy: string;
  readonly judgement: string;
}

/** Judge a minute by the time from DC1 to DC2. */
export function judged(rpm: number, board: Configuration, measured_ms: number): Calibration {
  const steps = rpm * board.steps_per_rev;
  const nominal_ms = (steps * Math.floor(stepAtOneRpm_us(board.steps_per_rev) / rpm)) / 1000;
  const pulses = steps * 2 ** board.microstep_exponent;
  const correction_us = Math.round(((nominal_ms - measured_ms) * 1000) / pulses) || 0;
  const factor = measured_ms / nominal_ms;
  const found = { rpm, nominal_ms, measured_ms, factor, correction_us };
  if (correction_us === 0) {
    return { ...found, remedy: "", judgement: "less than half a microsecond a pulse: nothing to correct" };
  }
  const [what, remedy] =
    correction_us > 0 ? ["too fast", `$CI${board.clock_correction_us + correction_us}`] : ["too slow", `$CH${board.interrupt_overhead_us - correction_us}`];
  return { ...found, remedy, judgement: `${what}: ${remedy}, then $R` };
}

/** Factor with its deviation in millionths: `1.000012 (+12 ppm)`. */
export function factorText(found: Calibration): string {
  const ppm = Math.round((found.factor - 1) * 1e6);
  return `${found.factor.toFixed(6)} (${ppm < 0 ? "" : "+"}${ppm} ppm)`;
}
