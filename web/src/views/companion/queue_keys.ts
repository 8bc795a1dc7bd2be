/** Which rows of the queue are meant, and what is done with them: by buttons and by keys. */

import { signal } from "@preact/signals";
import type { BoardSession } from "./board_session";
import { readGiven } from "./board_texts";
import { copiedText, deleted, inserted, moved, pasted, redone, undone } from "./queue_model";
import { ROWS, seedRow } from "./queue_row";

/** Rows that a page copied last, where the browser has no clipboard for it. */
let copied = "";

export class Selection {
  readonly range = signal({ from: 1, to: 1 });
  private anchor = 1;

  constructor(private readonly session: BoardSession) {}

  select(position: number, isExtended: boolean): void {
    if (!isExtended) this.anchor = position;
    this.range.value = { from: Math.min(this.anchor, position), to: Math.max(this.anchor, position) };
  }

  contains(position: number): boolean {
    const { from, to } = this.range.peek();
    return position >= from && position <= to;
  }

  get text(): string {
    const { from, to } = this.range.value;
    return from === to ? `row ${from}` : `rows ${from} to ${to}`;
  }

  private get count(): number {
    return this.range.peek().to - this.range.peek().from + 1;
  }

  private place(from: number, count: number): void {
    const first = Math.min(Math.max(from, 1), ROWS - count + 1);
    this.anchor = first;
    this.range.value = { from: first, to: first + count - 1 };
  }

  // ---- what is done with them ----

  /** Add a fresh row below; the last row of the queue falls out. */
  add(): void {
    this.insertAt(Math.min(this.range.peek().to + 1, ROWS));
  }

  /** Insert a fresh row above. */
  insert(): void {
    this.insertAt(this.range.peek().from);
  }

  private insertAt(position: number): void {
    const queue = this.session.queue.peek();
    this.session.sync.edit(inserted(queue, position, [seedRow(queue.steps_per_rev)]));
    this.place(position, 1);
  }

  remove(): void {
    const { from, to } = this.range.peek();
    this.session.sync.edit(deleted(this.session.queue.peek(), from, to));
    this.place(from, 1);
  }

  move(by: number): void {
    const { from, to } = this.range.peek();
    const count = this.count;
    this.session.sync.edit(moved(this.session.queue.peek(), from, to, from + by));
    this.place(from + by, count);
  }

  copy(): string {
    const { from, to } = this.range.peek();
    copied = copiedText(this.session.queue.peek(), from, to);
    navigator.clipboard?.writeText(copied).catch(() => undefined);
    return copied;
  }

  cut(): void {
    this.copy();
    this.remove();
  }

  /** Overwrite rows from the first selected one on. */
  paste(text: string): Promise<void> {
    return this.put(text, pasted);
  }

  /** Paste by a button: what the computer's clipboard has, if the browser lets the page read it. */
  async pasteByButton(isAbove: boolean): Promise<void> {
    const text = (await navigator.clipboard?.readText().catch(() => "")) || copied;
    await this.put(text, isAbove ? inserted : pasted);
  }

  private async put(text: string, change: typeof pasted): Promise<void> {
    const { from } = this.range.peek();
    const read = await readGiven(this.session.port, "pasted", text);
    if (!read) return;
    this.session.sync.edit(change(this.session.queue.peek(), from, read.rows));
    this.place(from, Math.min(read.rows.length, ROWS - from + 1));
  }

  undo(): void {
    this.session.sync.edit(undone(this.session.queue.peek()));
  }

  redo(): void {
    this.session.sync.edit(redone(this.session.queue.peek()));
  }

  /** Do what a key says; answers whether it says something. `isHead`: the focus is on a row's number. */
  key(event: KeyboardEvent, isHead: boolean): boolean {
    const control = event.ctrlKey || event.metaKey;
    if (event.altKey && event.key === "ArrowUp") this.move(-1);
    else if (event.altKey && event.key === "ArrowDown") this.move(1);
    else if (event.key === "Insert" && !control && !event.shiftKey) this.insert();
    else if (event.key === "Delete" && isHead && !control) this.remove();
    else if (control && isHead && event.key.toLowerCase() === "z") event.shiftKey ? this.redo() : this.undo();
    else if (control && isHead && event.key.toLowerCase() === "y") this.redo();
    else return false;
    return true;
  }
}

export function isEditKey(event: KeyboardEvent): boolean {
  const control = event.ctrlKey || event.metaKey;
  if (event.key === "Insert" || event.key === "Delete") return true;
  return (event.altKey && /^Arrow(Up|Down)$/.test(event.key)) || (control && /^[zy]$/i.test(event.key));
}
