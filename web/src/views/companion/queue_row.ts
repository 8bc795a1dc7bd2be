/** Row of a SAC's queue: its limits, and the command that writes it into a board.
 * Source: SAC user manual, motion, queue, Appendix C. */

export const ROWS = 30;
export const WORD = 2 ** 32;
export const MIN_CYCLE_US = 2;
export const MAX_ACCELERATION = 999;
/** Number of steps a turn of most motors, until a board has told its own. */
export const USUAL_STEPS_PER_REV = 200;

/** Entry of a queue. Its position is its place in the list; accelerations in hundredths, 0 to 99900. */
export interface QueueRow {
  readonly steps: number;
  readonly is_ccw: boolean;
  /** False: `steps` counts pulses. */
  readonly is_full: boolean;
  readonly rpm: number;
  readonly cycle_us: number;
  readonly is_linear: boolean;
  readonly acc_hundredths: number;
  readonly dec_hundredths: number;
  readonly extra_pulses: number;
  readonly is_sync: boolean;
  readonly wait_us: number;
}

/** Row as a board seeds its queue. */
export function seedRow(stepsPerRev: number): QueueRow {
  return {
    steps: stepsPerRev,
    is_ccw: false,
    is_full: true,
    ...byRpm(100, stepsPerRev),
    is_linear: false,
    acc_hundredths: 100,
    dec_hundredths: 100,
    extra_pulses: 0,
    is_sync: false,
    wait_us: 0,
  };
}

/** Microseconds of a full step at 1 RPM: 300,000 for 200 steps a turn. */
export function stepAtOneRpm_us(stepsPerRev: number): number {
  return Math.floor(60_000_000 / Math.max(stepsPerRev, 1));
}

export interface Velocity {
  readonly rpm: number;
  readonly cycle_us: number;
}

/** Velocity that `v` sets. */
export function byRpm(rpm: number, stepsPerRev: number): Velocity {
  return { rpm, cycle_us: Math.max(Math.floor(stepAtOneRpm_us(stepsPerRev) / rpm), MIN_CYCLE_US) };
}

/** Velocity that `vc` sets. */
export function byCycle(cycle_us: number, stepsPerRev: number): Velocity {
  const cycle = Math.max(cycle_us, MIN_CYCLE_US);
  return { rpm: Math.floor(stepAtOneRpm_us(stepsPerRev) / cycle), cycle_us: cycle };
}

/** True if a board could compute these RPM and this cycle from each other. */
export function isPossible(row: QueueRow, stepsPerRev: number): boolean {
  const f = stepAtOneRpm_us(stepsPerRev);
  return Math.floor(f / row.rpm) === row.cycle_us || Math.floor(f / row.cycle_us) === row.rpm;
}

/** Line that writes a row into a board's queue. The board computes RPM and cycle from each other: what was
 * entered is the one that the other follows from. */
export function rowCommand(position: number, row: QueueRow, stepsPerRev: number): string {
  const isByRpm = Math.floor(stepAtOneRpm_us(stepsPerRev) / row.rpm) === row.cycle_us;
  const velocity = isByRpm ? `v${row.rpm}` : `vc${row.cycle_us}`;
  return (
    `q${position}m${row.is_ccw ? "-" : ""}${row.steps}${velocity}` +
    `a${decimal(row.acc_hundredths)}d${decimal(row.dec_hundredths)}l${Number(row.is_linear)}` +
    `${row.is_full ? "f" : "p"}u${row.extra_pulses}s${Number(row.is_sync)}t${row.wait_us}`
  );
}

/** Format hundredths as the companion's files have them: `1`, `10.47`, `.5`. */
export function decimal(hundredths: number): string {
  if (hundredths === 0) return "0";
  const text = `${Math.floor(hundredths / 100)}.${String(hundredths % 100).padStart(2, "0")}`;
  return text.replace(/\.?0+$/, "").replace(/^0/, "");
}

export function sameRow(one: QueueRow, other: QueueRow): boolean {
  return (Object.keys(one) as (keyof QueueRow)[]).every((key) => one[key] === other[key]);
}
