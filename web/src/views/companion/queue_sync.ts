/** Queue of the editor and queue of the board: what is sent, read back, and thrown away. */

import { effect, signal } from "@preact/signals";
import { notify, notifyError } from "../../parts/notices";
import type { Listing } from "./board_texts";
import type { KeptBoard } from "./kept_board";
import { changed, newQueue, replacedByBoard, seenOnBoard, sentToBoard, unsent, type QueueState } from "./queue_model";
import { isPossible, rowCommand, sameRow, stepAtOneRpm_us } from "./queue_row";

export class QueueSync {
  readonly queue = signal<QueueState>(newQueue());
  readonly isOffline = signal(false);
  readonly isSending = signal(false);

  /** `kept`: has what was left unsent; it is sent when somebody wants it. `ask`: types a line at the board; `list`:
   * lists its queue; `stepsPerRev`: the board's own; `isRead`: called when its queue was read back. */
  constructor(
    kept: KeptBoard,
    private readonly ask: (line: string) => Promise<string[]>,
    private readonly list: () => Promise<Listing | string>,
    private readonly stepsPerRev: () => number,
    private readonly isRead: () => void,
  ) {
    const left = kept.left();
    if (left) {
      this.queue.value = left;
      this.isOffline.value = true;
    }
    effect(() => kept.keep(this.queue.value));
  }

  /** Rows that were edited and are not in the board. */
  get missing(): number {
    return this.queue.value.board ? unsent(this.queue.value).length : 0;
  }

  /** Take what the board lists; what was edited and not sent stays. What was edited before the first list is sent now. */
  seen(rows: QueueState["rows"]): void {
    const isFirst = this.queue.peek().board === undefined;
    this.queue.value = seenOnBoard(this.queue.peek(), rows, this.stepsPerRev());
    if (isFirst && !this.isOffline.peek() && unsent(this.queue.peek()).length) void this.sendRows();
  }

  /** Take an edit; it is sent at once unless the editor is offline. */
  edit(queue: QueueState): void {
    const before = this.queue.peek();
    if (queue === before) return;
    this.queue.value = queue;
    if (!this.isOffline.peek() && before.board) void this.sendRows();
  }

  /** Take a file's rows into the editor, in one step that can be undone. */
  take(rows: QueueState["rows"]): void {
    this.edit(changed(this.queue.peek(), rows));
  }

  setOffline(isOffline: boolean): void {
    this.isOffline.value = isOffline;
    if (!isOffline) void this.sendRows();
  }

  /** Send the rows that the board does not have yet, and read them back. Answers whether it has them now. */
  async sendRows(): Promise<boolean> {
    if (this.isSending.peek()) return false;
    this.isSending.value = true;
    try {
      while (unsent(this.queue.peek()).length) await this.readBack(await this.sendUnsent());
      return true;
    } catch (error) {
      this.isOffline.value = true;
      notify(`${(error as Error).message}\nThe editor is offline now; "Update queue" sends what is missing.`, true);
      return false;
    } finally {
      this.isSending.value = false;
    }
  }

  private async sendUnsent(): Promise<Set<number>> {
    const sent = new Set<number>();
    for (let [position] = unsent(this.queue.peek()); position !== undefined; [position] = unsent(this.queue.peek())) {
      await this.sendRow(position);
      sent.add(position);
    }
    return sent;
  }

  private async sendRow(position: number): Promise<void> {
    const { rows, steps_per_rev } = this.queue.peek();
    const row = rows[position - 1]!;
    if (!isPossible(row, steps_per_rev)) {
      const cycle_us = Math.floor(stepAtOneRpm_us(steps_per_rev) / row.rpm);
      throw new Error(
        `row ${position}: RPM ${row.rpm} and cycle ${row.cycle_us} contradict each other at ${steps_per_rev} steps` + ` a turn; write cycle ${cycle_us}`,
      );
    }
    await this.ask(rowCommand(position, row, steps_per_rev));
    this.queue.value = sentToBoard(this.queue.peek(), position, row);
  }

  private async readBack(positions: ReadonlySet<number>): Promise<void> {
    const wanted = this.queue.peek().board!;
    const listing = await this.list();
    if (typeof listing === "string") throw new Error(`the rows were sent, but could not be read back: ${listing}`);
    const wrong = [...positions].filter((p) => !sameRow(wanted[p - 1]!, listing.rows[p - 1]!));
    this.seen(listing.rows);
    if (wrong.length) throw new Error(`the board does not have what was sent: row ${wrong.join(", ")}`);
    this.isRead();
  }

  /** Throw away what was not sent: the editor has what the board has. */
  async revert(): Promise<void> {
    try {
      const listing = await this.list();
      if (typeof listing === "string") throw new Error(listing);
      this.queue.value = replacedByBoard(this.queue.peek(), listing.rows, this.stepsPerRev());
    } catch (error) {
      notifyError(error);
    }
  }
}
