/** Stream of a long file into a board's queue: a row is typed when there is room, as soft_ops tell, and goes into force when
 * its echo is whole. Pausing ends it behind the row that runs. Without a screen.
 * Source: SAC user manual, companion app, command buffer, soft_ops, l. */

import { signal } from "@preact/signals";
import { notify } from "../../parts/notices";
import { LinkError, type AskOptions, type Operation } from "./board_link";
import type { Speed } from "./board_texts";

/** Number of rows in the board, the running one too: its queue holds 30. */
export const MOST_IN_BOARD = 29;

/** Silence after which the board is looked at. */
const LOOK_MS = 1000;

/** What a stream needs of its board. */
export interface StreamedBoard {
  readonly isReady: boolean;
  readonly isOpsOn: boolean;
  ask(line: string, options?: AskOptions): Promise<string[]>;
  speed(): Promise<Speed | string>;
}

export interface StreamState {
  readonly file: string;
  readonly moves: readonly string[];
  /** Rows that have run; the next begins behind them. */
  readonly ended: number;
  readonly phase: "rests" | "runs" | "pauses";
}

export class RowStreamer {
  readonly state = signal<StreamState | undefined>(undefined);
  private sent = 0;
  private isMoving = false;
  private why = "";
  private wake: () => void = () => {};

  constructor(private readonly board: StreamedBoard) {}

  get isBusy(): boolean {
    const state = this.state.peek();
    return state !== undefined && state.phase !== "rests";
  }

  /** Take the moves of a file, or of none. */
  take(file: string, moves: readonly string[]): void {
    if (!this.isBusy) this.state.value = moves.length ? { file, moves, ended: 0, phase: "rests" } : undefined;
  }

  /** Take a signal of soft_ops. A begin without the end before means that this one was lost. */
  hear({ kind }: Operation): void {
    if (!this.isBusy) return;
    if (this.isMoving) this.put({ ended: Math.min(this.state.peek()!.ended + 1, this.sent) });
    this.isMoving = kind === "begins";
    this.wake();
  }

  /** End it: the board has gone, has started again, or does what somebody else wants. */
  giveUp(why: string): void {
    if (!this.isBusy) return;
    this.why = why;
    this.wake();
  }

  /** End it behind the row that runs. */
  pause(): void {
    if (this.state.peek()?.phase === "runs") this.put({ phase: "pauses" });
    this.wake();
  }

  /** Run the rows that have not run yet. The motor has to stand. */
  async run(): Promise<void> {
    const { board } = this;
    if (this.isBusy || !this.state.peek()) return;
    this.put({ phase: "runs" });
    [this.sent, this.isMoving, this.why] = [this.state.peek()!.ended, false, ""];
    const wasOn = board.isOpsOn;
    try {
      const speed = await board.speed();
      if (typeof speed === "string" || speed.period_us > 0) throw new LinkError("the motor runs; stop it first");
      if (!wasOn) await this.type("$O1");
      await this.typeRows();
      if (this.phase === "pauses") await this.halt();
      else await this.until(() => this.state.peek()!.ended === this.sent);
    } catch (error) {
      await this.explain(error as Error);
    } finally {
      if (!wasOn && board.isReady) await this.type("$O0").catch(() => {});
      this.put({ phase: "rests" });
    }
  }

  private get phase(): StreamState["phase"] {
    return this.state.peek()!.phase;
  }

  private async typeRows(): Promise<void> {
    const { moves } = this.state.peek()!;
    while (this.sent < moves.length && this.phase === "runs") {
      await this.until(() => this.phase !== "runs" || this.sent - this.state.peek()!.ended < MOST_IN_BOARD);
      if (this.phase !== "runs") return;
      this.sent += 1;
      await this.board.ask(moves[this.sent - 1]!, { isQuiet: true, isChecked: true });
    }
  }

  /** Let the row that runs end, and drop the others; `S` drops one that waits for its sync. */
  private async halt(): Promise<void> {
    await this.type("l");
    while (this.isMoving && !(await this.stands())) await this.signal();
    await this.type("S");
  }

  private async explain(error: Error): Promise<void> {
    const because = this.why || error.message;
    this.why = "";
    if (this.board.isReady) await this.halt().catch(() => {});
    const { file, moves, ended } = this.state.peek()!;
    notify(`${file}: ${because}; rows up to ${ended} of ${moves.length} have run`, true);
  }

  private type(line: string): Promise<string[]> {
    return this.board.ask(line, { isQuiet: true });
  }

  /** Wait until something is so. Throws LinkError: it was given up. */
  private async until(isSo: () => boolean): Promise<void> {
    while (!isSo()) {
      if (this.why) throw new LinkError(this.why);
      await this.signal();
    }
    if (this.why) throw new LinkError(this.why);
  }

  /** True if the motor stands: what was stopped ends without a signal. */
  private async stands(): Promise<boolean> {
    const speed = await this.board.speed();
    return typeof speed !== "string" && speed.period_us === 0;
  }

  /** Wait for a signal, or for a while. */
  private signal(): Promise<void> {
    return new Promise((done) => {
      const timer = setTimeout(done, LOOK_MS);
      this.wake = () => {
        clearTimeout(timer);
        done();
      };
    });
  }

  private put(change: Partial<StreamState>): void {
    this.state.value = { ...this.state.peek()!, ...change };
  }
}
