/** A port that terminals of this page are at: it stays open, with what it said, while the page is there, in sight or not. */

import { signal } from "@preact/signals";
import { type Piece, PortRecord } from "../../model/port_record";
import { TypedQueue, type TypedState } from "../../model/typed_queue";
import type { TerminalHandle } from "../../net/channels";
import { link } from "../../store";

/** From so many bytes on a text is told about while it is typed. */
const LONG_BYTES = 2000;

export class TerminalPort {
  /** What is to be said of the port: how many have it open, or why it is closed. */
  readonly note = signal("");
  readonly isOpen = signal(false);
  /** A long text that is being typed; null: there is none. */
  readonly typing = signal<TypedState | null>(null);
  /** How the last long text ended. */
  readonly typed = signal("");
  readonly record = new PortRecord();
  /** Grows when there is something new, or all is gone. */
  readonly news = signal(0);
  readonly listeners = new Set<(piece: Piece | null) => void>();
  private handle: TerminalHandle | null = null;
  private stopped: TypedState | null = null;
  private readonly queue = new TypedQueue((bytes) => this.handle?.send(bytes) ?? false);

  constructor(readonly port: string) {
    this.open();
  }

  /** Open the port, again after it was closed. */
  open(): void {
    this.handle?.close();
    this.note.value = "opening";
    this.handle = link.open(this.port, {
      bytes: (bytes, at_s) => this.hear({ at_s, bytes }),
      opened: ({ clients }) => {
        this.queue.reset();
        this.isOpen.value = true;
        const others = clients ? `, ${clients} other client${clients > 1 ? "s" : ""}` : "";
        this.note.value = `open${others}`;
      },
      closed: (why) => this.hasClosed(`closed: ${why}`),
      taken: (bytes) => {
        this.queue.took(bytes);
        this.tellTyping();
      },
    });
  }

  close(): void {
    this.handle?.close();
    this.handle = null;
    this.hasClosed("closed");
  }

  clear(): void {
    this.record.clear();
    this.tell(null);
  }

  type(bytes: Uint8Array): void {
    if (!this.isOpen.peek()) return;
    this.typed.value = "";
    this.queue.put(bytes);
    this.hear({ at_s: NaN, bytes, isSent: true });
    this.tellTyping();
  }

  /** Type no more of a long text; what is under way is still taken. */
  stopTyping(): void {
    if (!this.typing.peek()) return;
    this.stopped = this.queue.stop();
    this.tellTyping();
  }

  private tellTyping(): void {
    const { of, taken } = this.queue.state;
    const isLong = of > LONG_BYTES || this.typing.peek() !== null;
    if (isLong && taken < of) {
      this.typing.value = { of: this.stopped?.of ?? of, taken };
    } else if (this.typing.peek()) {
      this.typing.value = null;
      const all = this.stopped?.of ?? of;
      this.typed.value = this.stopped ? `stopped: ${taken} of ${all} bytes were typed` : `${all} bytes were typed`;
      this.stopped = null;
    }
  }

  private hasClosed(why: string): void {
    this.isOpen.value = false;
    this.note.value = why;
    const typing = this.typing.peek();
    if (typing) this.typed.value = `the port had taken ${typing.taken} of ${typing.of} bytes`;
    this.typing.value = this.stopped = null;
    this.queue.reset();
  }

  private hear(piece: Piece): void {
    this.record.add(piece);
    this.tell(piece);
  }

  private tell(piece: Piece | null): void {
    for (const listener of this.listeners) listener(piece);
    this.news.value += 1;
  }
}

const ports = new Map<string, TerminalPort>();

export function terminalPort(port: string): TerminalPort {
  let known = ports.get(port);
  if (!known) ports.set(port, (known = new TerminalPort(port)));
  return known;
}
