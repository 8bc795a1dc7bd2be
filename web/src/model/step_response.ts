/** Figures of a step response: how fast, how far over, when it stays. Pure. */

export interface StepFigures {
  /** Time from 10 % to 90 % of the step; NaN if it never gets there. */
  rise_s: number;
  /** How far over the set-point, in percent of the step. */
  overshoot_percent: number;
  /** Time after which it stays within 2 % of the step around the set-point; NaN if it does not. */
  settling_s: number;
  /** What is missing at the end, in the unit of the values. */
  finalError: number;
}

const BAND = 0.02;
/** Part at the end whose mean is where the shaft stands. */
const END_PART = 0.1;

/** Compute the figures of `values` at `times_s`, where the step from `from` to `to` is at time 0. */
export function stepFigures(times_s: number[], values: number[], from: number, to: number): StepFigures {
  const amplitude = to - from;
  const part = values.map((value) => (value - from) / amplitude);
  const after = times_s.findIndex((time) => time >= 0);
  if (!amplitude || after < 0) return { rise_s: NaN, overshoot_percent: NaN, settling_s: NaN, finalError: NaN };
  const crossing = (level: number) => times_s[part.findIndex((value, at) => at >= after && value >= level)] ?? NaN;
  const tail = part.slice(-Math.max(1, Math.round((part.length - after) * END_PART)));
  const end = tail.reduce((sum, value) => sum + value, 0) / tail.length;
  let settled = part.length;
  while (settled > after && Math.abs(part[settled - 1]! - 1) <= BAND) settled--;
  return {
    rise_s: crossing(0.9) - crossing(0.1),
    overshoot_percent: Math.max(0, (Math.max(...part.slice(after)) - 1) * 100),
    settling_s: settled < part.length ? Math.max(0, times_s[settled]!) : NaN,
    finalError: (1 - end) * amplitude,
  };
}
