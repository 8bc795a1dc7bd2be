/** What is typed at a port and waits: it goes in pieces, as fast as the board takes them. Pure. */

/** Bytes under way at most: the door closes a port of which too many wait. */
export const WINDOW_BYTES = 8192;

export interface TypedState {
  /** Bytes of the text that is being typed, and how many of them the port has taken. */
  of: number;
  taken: number;
}

export class TypedQueue {
  private waiting: Uint8Array[] = [];
  private sent = 0;
  private taken = 0;
  /** Where the text that is being typed begins. */
  private base = 0;

  /** `send`: false: there is no way to send. */
  constructor(private readonly send: (bytes: Uint8Array) => boolean) {}

  get state(): TypedState {
    const waiting = this.waiting.reduce((sum, each) => sum + each.length, 0);
    return { of: this.sent + waiting - this.base, taken: this.taken - this.base };
  }

  put(bytes: Uint8Array): void {
    if (!this.waiting.length && this.taken >= this.sent) this.base = this.sent;
    if (bytes.length) this.waiting.push(bytes);
    this.pump();
  }

  /** The port has taken so many bytes since it was opened. */
  took(bytes: number): void {
    this.taken = bytes;
    this.pump();
  }

  /** Type no more of it; answers how it stands. */
  stop(): TypedState {
    const { of } = this.state;
    this.waiting = [];
    return { of, taken: this.taken - this.base };
  }

  /** The port is another one, or open again. */
  reset(): void {
    this.waiting = [];
    this.sent = this.taken = this.base = 0;
  }

  private pump(): void {
    while (this.waiting.length && this.sent - this.taken < WINDOW_BYTES) {
      const next = this.waiting[0]!;
      const part = next.subarray(0, WINDOW_BYTES - (this.sent - this.taken));
      if (!this.send(part)) {
        this.waiting = [];
        return;
      }
      this.sent += part.length;
      if (part.length === next.length) this.waiting.shift();
      else this.waiting[0] = next.subarray(part.length);
    }
  }
}
