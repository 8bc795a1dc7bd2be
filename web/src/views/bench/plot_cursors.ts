/** Cursors of plots: two times, kept for a run of the bench. */

import { Kept } from "../../kept";
import { hello } from "../../store";

/** Times of both cursors, in a run of the bench: the next one has other times. */
interface Cursors {
  instance: string;
  a: number | null;
  b: number | null;
}

/** One of the cursors, as a signal. */
export class Cursor {
  constructor(
    private readonly both: Kept<Cursors>,
    private readonly which: "a" | "b",
  ) {}

  get value(): number | null {
    return this.in(this.both.value, hello.value?.instance);
  }

  set value(at_s: number | null) {
    const instance = hello.peek()?.instance ?? "";
    const before = this.both.peek();
    const others = before.instance === instance ? before : { a: null, b: null };
    this.both.value = { ...others, instance, [this.which]: at_s };
  }

  peek(): number | null {
    return this.in(this.both.peek(), hello.peek()?.instance);
  }

  private in(both: Cursors, instance: string | undefined): number | null {
    return both.instance === instance ? both[this.which] : null;
  }
}

/** Both cursors of a plot. */
export function cursorsOf(id: string): [Cursor, Cursor] {
  const both = new Kept(`plot.${id}.cursors`, () => ({ instance: "", a: null, b: null }), readCursors);
  return [new Cursor(both, "a"), new Cursor(both, "b")];
}

function readCursors(raw: unknown): Cursors | undefined {
  const { instance, a, b } = (raw ?? {}) as Partial<Cursors>;
  const isTime = (at_s: unknown) => at_s === null || (typeof at_s === "number" && Number.isFinite(at_s));
  return typeof instance === "string" && isTime(a) && isTime(b) ? { instance, a: a ?? null, b: b ?? null } : undefined;
}
