/** Figures of a step response, as `hil step` computes them: how fast, how far over, when it stays. Pure. */

export interface StepRows {
  times_s: number[];
  setpoint: number[];
  position: number[];
}

export interface StepFigures {
  /** Time from 10 % to 90 % of the step; NaN: it never gets there. */
  rise_s: number;
  /** How far over the set-point, in percent of the step. */
  overshoot_percent: number;
  /** Time after which it stays within 2 % of the step around the set-point; NaN: it does not. */
  settling_s: number;
  /** Mean of the last tenth less the set-point, in the unit of the position. */
  final_error: number;
}

const BAND = 0.02;
const END_PART = 10;
const NONE: StepFigures = { rise_s: NaN, overshoot_percent: NaN, settling_s: NaN, final_error: NaN };

/** Compute the figures of the last step of the set-point. */
export function stepFigures({ times_s, setpoint, position }: StepRows): StepFigures {
  let at = setpoint.length - 1;
  while (at > 0 && setpoint[at] === setpoint[at - 1]) at--;
  const start = position[at - 1];
  const target = setpoint[at];
  if (start === undefined || target === undefined || start === target) return NONE;
  const after = times_s.slice(at).map((time) => time - times_s[at]!);
  const share = position.slice(at).map((value) => (value - start) / (target - start));
  const tail = position.slice(-Math.max(1, Math.floor(share.length / END_PART)));
  const crossing = (level: number) => after[share.findIndex((value) => value >= level)] ?? NaN;
  const outside = share.findLastIndex((value) => Math.abs(value - 1) > BAND);
  return {
    rise_s: crossing(0.9) - crossing(0.1),
    overshoot_percent: Math.max(0, share.reduce((most, value) => Math.max(most, value), -Infinity) - 1) * 100,
    settling_s: outside < 0 ? 0 : (after[outside + 1] ?? NaN),
    final_error: tail.reduce((sum, value) => sum + value, 0) / tail.length - target,
  };
}

/** Why a recording is none of the one step that was asked for: something else moves the set-point, or stopped it. Empty: it
 * is one. `target`: where the set-point was to go. */
export function otherMotion({ setpoint }: StepRows, target: number, step: number): string {
  const near = Math.abs(step) / 100 + 0.02;
  const reached = setpoint.findIndex((value) => Math.abs(value - target) <= near);
  if (reached < 0) return "the set-point did not get there: it was stopped, or something else moves it";
  const held = setpoint[reached];
  return setpoint.slice(reached).every((value) => value === held) ? "" : "the set-point moved on: it was stopped, or something else moves it";
}
