/** Calibration of a board: it runs for a minute, and its signals are timed. */

import { signal } from "@preact/signals";
import { notify } from "../../parts/notices";
import { LinkError, type AskOptions, type Operation } from "./board_link";
import { CALIBRATION_S, calibrationLine, factorText, judged, LONGEST_S, type Calibration } from "./calibration";
import type { Configuration, Speed } from "./board_texts";

/** What a calibration needs of its board. */
export interface CalibratedBoard {
  readonly isReady: boolean;
  readonly isOpsOn: boolean;
  ask(line: string, options?: AskOptions): Promise<string[]>;
  speed(): Promise<Speed | string>;
  type(line: string): Promise<boolean>;
  stop(letter: "S" | "s"): Promise<void>;
}

export interface CalibrationState {
  readonly rpm: number;
  readonly elapsed_s: number;
}

export class Calibrator {
  readonly running = signal<CalibrationState | undefined>(undefined);
  /** Results by RPM. */
  readonly results = signal<ReadonlyMap<number, Calibration>>(new Map());
  private waiter: ((operation: Operation | Error) => void) | undefined;

  constructor(private readonly board: CalibratedBoard) {}

  /** Take a signal of soft_ops. */
  hear(operation: Operation): void {
    this.waiter?.(operation);
  }

  /** End what runs. */
  giveUp(why: string): void {
    this.waiter?.(new LinkError(why));
  }

  /** Run for a minute at a speed and time it. The motor turns, without a ramp. */
  async run(rpm: number, configuration: Configuration): Promise<void> {
    const { board } = this;
    if (this.running.peek()) return;
    const begin = calibrationLine(rpm, configuration);
    if ("refused" in begin) return notify(begin.refused, true);
    this.running.value = { rpm, elapsed_s: 0 };
    const wasOn = board.isOpsOn;
    try {
      await this.checkStanding();
      await this.board.ask("$O1");
      const begun = this.signal("begins", 3);
      await this.board.ask(begin.line);
      const begun_ms = (await begun).at_ms;
      const found = judged(rpm, configuration, (await this.minute(rpm)).at_ms - begun_ms);
      this.results.value = new Map(this.results.peek()).set(rpm, found);
      notify(`${rpm} RPM: factor ${factorText(found)}; ${found.judgement}`);
    } catch (error) {
      notify(`Calibration at ${rpm} RPM: ${(error as Error).message}`, true);
      if (board.isReady) await board.stop("S");
    } finally {
      this.running.value = undefined;
      if (!wasOn && board.isReady) await board.type("$O0");
    }
  }

  private async checkStanding(): Promise<void> {
    const speed = await this.board.speed();
    if (typeof speed === "string" || speed.period_us > 0) throw new LinkError("the motor runs; stop it first");
  }

  private async minute(rpm: number): Promise<Operation> {
    const start_ms = performance.now();
    const timer = window.setInterval(() => {
      const elapsed_s = Math.min((performance.now() - start_ms) / 1000, CALIBRATION_S);
      this.running.value = { rpm, elapsed_s };
    }, 500);
    try {
      return await this.signal("ends", LONGEST_S);
    } finally {
      window.clearInterval(timer);
    }
  }

  /** Wait for a signal of soft_ops. */
  private signal(kind: Operation["kind"], timeout_s: number): Promise<Operation> {
    return new Promise((done, failed) => {
      const timer = window.setTimeout(() => settle(new LinkError(`no signal came within ${timeout_s} s`)), timeout_s * 1000);
      const settle = (heard: Operation | Error) => {
        if (!(heard instanceof Error) && heard.kind !== kind) return;
        window.clearTimeout(timer);
        if (this.waiter === settle) this.waiter = undefined;
        if (heard instanceof Error) failed(heard);
        else done(heard);
      };
      this.waiter = settle;
    });
  }
}
