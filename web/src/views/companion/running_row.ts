/** Which row of its queue a board runs, from what was typed at it and from the signals of soft_ops. A listing
 * would tell too, but takes 0.4 s of the line, behind which the signals would wait. Without a screen.
 * Source: SAC user manual, queue, loop, xRef, continuous, stop, next. */

import { ROWS } from "./queue_row";

/** What runs: a row's position, something that is no row, or unknown; undefined: nothing. */
export type Running = number | "one-shot" | "continuous" | "unknown" | undefined;

export interface Loop {
  readonly start: number | undefined;
  readonly finish: number | undefined;
  readonly isOn: boolean;
}

const NO_LOOP: Loop = { start: undefined, finish: undefined, isOn: false };

export interface Motion {
  readonly running: Running;
  /** Where the next queued command goes; undefined until a listing has told. */
  readonly next: number | undefined;
  readonly loop: Loop;
  /** What comes before anything else, the next first. */
  readonly urgent: readonly Running[];
  readonly queued: readonly number[];
  /** Row of the loop that comes next. */
  readonly loopNext: number | undefined;
}

export const STANDING: Motion = {
  running: undefined,
  next: undefined,
  loop: NO_LOOP,
  urgent: [],
  queued: [],
  loopNext: undefined,
};

function after(position: number): number {
  return (position % ROWS) + 1;
}

function isRow(position: number): boolean {
  return position >= 1 && position <= ROWS;
}

/** Take note of a line that was typed. */
export function afterLine(motion: Motion, line: string): Motion {
  const text = line.split(" ", 1)[0]!;
  if (/^[Ss$]/.test(text)) return { ...STANDING, next: motion.next, running: motion.running };
  const move = /^(x?)m(-?)(\d*)/i.exec(text);
  if (move) return afterMove(motion, move[1] !== "", Number(move[3]));
  const recall = /^x(\d+)/i.exec(text);
  if (recall) {
    const position = Number(recall[1]);
    return isRow(position) ? { ...motion, urgent: [position, ...motion.urgent] } : motion;
  }
  if (/^x?l\d|^xl/i.test(text)) return { ...motion, urgent: [...motion.urgent, "unknown"] };
  if (/^l/i.test(text)) return afterLoop(motion, text.slice(1));
  return motion;
}

function afterMove(motion: Motion, isOneShot: boolean, steps: number): Motion {
  if (steps === 0) return { ...motion, urgent: ["continuous", ...motion.urgent] };
  if (isOneShot) return { ...motion, urgent: ["one-shot", ...motion.urgent] };
  if (motion.next === undefined) return motion;
  return { ...motion, queued: [...motion.queued, motion.next], next: after(motion.next) };
}

function afterLoop(motion: Motion, text: string): Motion {
  if (text === "") return { ...motion, loop: NO_LOOP, loopNext: undefined, queued: [] };
  const [, what, digits] = /^([sfa])(\d*)/i.exec(text) ?? [];
  const position = Number(digits);
  let { start, finish, isOn } = motion.loop;
  if (/a/i.test(what ?? "")) [start, finish] = [1, ROWS];
  else if (/s/i.test(what ?? "") && isRow(position)) start = position;
  else if (/f/i.test(what ?? "") && isRow(position)) finish = position;
  else return motion;
  const begins = !isOn && start !== undefined && finish !== undefined && start !== finish;
  isOn = isOn || begins;
  return { ...motion, loop: { start, finish, isOn }, loopNext: begins ? start : motion.loopNext };
}

/** A command begins (DC1). */
export function afterBegin(motion: Motion): Motion {
  const [first, ...urgent] = motion.urgent;
  if (first !== undefined) return { ...motion, running: first, urgent };
  if (motion.loop.isOn && motion.loopNext !== undefined) {
    const { start, finish } = motion.loop;
    const loopNext = motion.loopNext === finish ? start : after(motion.loopNext);
    return { ...motion, running: motion.loopNext, loopNext };
  }
  const [row, ...queued] = motion.queued;
  return { ...motion, running: row ?? "unknown", queued };
}

/** The command has ended (DC2). */
export function afterEnd(motion: Motion): Motion {
  return { ...motion, running: undefined };
}

/** Take what a listing says: where the queue is, while the motor moves or stands. Standing, it is the place of
 * the next command; moving, that or the running row. */
export function afterListing(motion: Motion, at: number, isMoving: boolean): Motion {
  if (!isMoving) return { ...motion, running: undefined, next: at };
  if (motion.running === "one-shot" || motion.running === "continuous") return motion;
  if (motion.running === at) return motion;
  const { loop } = motion;
  const loopNext = loop.isOn ? (at === loop.finish ? loop.start : after(at)) : undefined;
  return { ...motion, running: at, loopNext };
}

/** Words for what runs. */
export function runningText(running: Running): string {
  if (running === undefined) return "";
  return typeof running === "number" ? `row ${running}` : running === "unknown" ? "" : running;
}
