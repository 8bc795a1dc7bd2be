import { afterAll, beforeEach, describe, expect, it, vi } from "vitest";

const texts = new Map<string, string>();
vi.stubGlobal("localStorage", {
  getItem: (key: string) => texts.get(key) ?? null,
  setItem: (key: string, text: string) => void texts.set(key, text),
  removeItem: (key: string) => void texts.delete(key),
});
afterAll(() => vi.unstubAllGlobals());

const { flush, keptFor } = await import("../src/kept");
const { KeptBoard, readCells, readOneShots, readQueue } = await import("../src/views/companion/kept_board");
const { newQueue, seenOnBoard, sentToBoard, setRow, unsent } = await import("../src/views/companion/queue_model");

const SEEN = seenOnBoard(newQueue(), newQueue().rows, 200);
const EDITED = setRow(SEEN, 3, { ...SEEN.rows[2]!, steps: 77 });

/** What a page finds that was loaded just now. */
function again(): InstanceType<typeof KeptBoard> {
  flush();
  return new KeptBoard("s1");
}

let benches = 0;
beforeEach(() => {
  keptFor.value = `bench${benches++}`;
});

describe("rows that were not sent", () => {
  it("come back, and go with the board's other rows", () => {
    new KeptBoard("s1").keep(EDITED);
    const left = again().left()!;
    expect([unsent(left), left.rows[2]!.steps]).toEqual([[3], 77]);
    const board = SEEN.rows.map((row, at) => (at === 4 ? { ...row, steps: 55 } : row));
    expect(unsent(seenOnBoard(left, board, 200))).toEqual([3]);
    expect(new KeptBoard("s2").left()).toBeUndefined();
  });

  it("are kept no longer than they are missing in the board", () => {
    const kept = new KeptBoard("s1");
    kept.keep(EDITED);
    kept.keep(sentToBoard(EDITED, 3, EDITED.rows[2]!));
    expect(again().left()).toBeUndefined();
  });

  it("stay where they were typed before the board was seen", () => {
    const early = setRow(newQueue(), 3, { ...newQueue().rows[2]!, steps: 77 });
    const board = newQueue().rows.map((row) => ({ ...row, steps: 55 }));
    const seen = seenOnBoard(early, board, 200);
    expect([seen.rows[2]!.steps, seen.rows[3]!.steps, unsent(seen)]).toEqual([77, 55, [3]]);
  });
});

describe("what is damaged", () => {
  const { rows, steps_per_rev } = EDITED;
  const good = { rows, board: SEEN.rows, steps_per_rev };

  it.each([
    { ...good, rows: rows.slice(1) },
    { ...good, board: undefined },
    { ...good, steps_per_rev: 0 },
    { ...good, rows: rows.map((row) => ({ ...row, steps: "7" })) },
    { ...good, rows: rows.map((row) => ({ ...row, steps: -1 })) },
    { ...good, rows: rows.map(() => null) },
    { ...good, rows: rows.map((row) => ({ ...row, more: 1 })) },
  ])("is no queue: %#", (raw) => expect(readQueue(JSON.parse(JSON.stringify(raw)))).toBeUndefined());

  it("is told from what is not", () => {
    expect(readQueue(JSON.parse(JSON.stringify(good)))).toEqual(good);
    expect([readOneShots({ lines: ["m1"] }), readOneShots(null), readOneShots({ lines: Array(100).fill(5) })]).toEqual([undefined, undefined, undefined]);
    expect(readOneShots({ lines: Array(100).fill("m1") })?.isSaved).toBe(false);
    expect(readCells({ "1.rpm": { text: "x", was: "100" }, "2.rpm": null, "3.rpm": { text: 5 } })).toEqual({ "1.rpm": { text: "x", was: "100" } });
  });
});

describe("a cell that could not be taken", () => {
  it("keeps its text until it is taken back", () => {
    const kept = new KeptBoard("s1");
    kept.putCell("1.rpm", { text: "fast", was: "100" });
    expect(again().cells.value).toEqual({ "1.rpm": { text: "fast", was: "100" } });
    kept.putCell("1.rpm", null);
    expect(again().cells.value).toEqual({});
  });
});
