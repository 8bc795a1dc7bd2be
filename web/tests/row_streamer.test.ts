import { describe, expect, test, vi } from "vitest";
import { LinkError, type AskOptions } from "../src/views/companion/board_link";
import { MOST_IN_BOARD, RowStreamer } from "../src/views/companion/row_streamer";

const said = vi.hoisted(() => ({ notices: [] as string[] }));
vi.mock("../src/parts/notices", () => ({ notify: (text: string) => said.notices.push(text) }));

/** Board that takes moves, and runs one when `step` is called. */
class Board {
  readonly typed: string[] = [];
  /** Lines whose end goes out when their echo is whole. */
  readonly checked: string[] = [];
  isReady = true;
  isOpsOn = false;
  queue = 0;
  most = 0;
  runs = false;
  fails = "";
  readonly streamer = new RowStreamer(this);

  async ask(line: string, options: AskOptions = {}): Promise<string[]> {
    this.typed.push(line);
    if (options.isChecked) this.checked.push(line);
    if (line === this.fails) throw new LinkError(`"${line}" came back as "m"`);
    if (line.startsWith("m")) this.queue += 1;
    if (line === "l" || line === "S") this.queue = this.runs ? 1 : 0;
    this.most = Math.max(this.most, this.queue);
    return [];
  }

  async speed() {
    return { rpm: this.runs ? 60 : 0, period_us: this.runs ? 5000 : 0 };
  }

  begin(): void {
    this.runs = true;
    this.streamer.hear({ kind: "begins", at_ms: 0 });
  }

  end(): void {
    this.runs = false;
    this.queue -= 1;
    this.streamer.hear({ kind: "ends", at_ms: 0 });
  }

  /** Let promises go on. */
  async settle(): Promise<void> {
    for (let round = 0; round < 300; round++) await Promise.resolve();
  }

  async runRows(count: number): Promise<void> {
    for (let row = 0; row < count; row++) {
      this.begin();
      this.end();
      await this.settle();
    }
  }

  get ended(): number {
    return this.streamer.state.value!.ended;
  }
}

function begun(count: number): { board: Board; done: Promise<void> } {
  const board = new Board();
  board.streamer.take(
    "long.txt",
    Array.from({ length: count }, (_, row) => `m${row + 1}`),
  );
  return { board, done: board.streamer.run() };
}

describe("a stream of rows", () => {
  test("keeps the pace of the board, and ends with the last row", async () => {
    const { board, done } = begun(100);
    await board.settle();
    expect(board.queue).toBe(MOST_IN_BOARD);
    await board.runRows(100);
    await done;
    expect(board.most).toBe(MOST_IN_BOARD);
    expect(board.typed).toEqual(["$O1", ...Array.from({ length: 100 }, (_, row) => `m${row + 1}`), "$O0"]);
    expect(board.checked).toEqual(board.typed.slice(1, -1));
    expect([board.ended, board.streamer.state.value!.phase]).toEqual([100, "rests"]);
  });

  test("pauses behind the row that runs, and goes on with the next", async () => {
    const { board, done } = begun(60);
    await board.settle();
    await board.runRows(7);
    board.begin();
    board.streamer.pause();
    await board.settle();
    expect(board.streamer.state.value!.phase).toBe("pauses");
    board.end();
    await done;
    expect(board.ended).toBe(8);
    const before = board.typed.length;
    const again = board.streamer.run();
    await board.settle();
    expect(board.typed.slice(before, before + 2)).toEqual(["$O1", "m9"]);
    await board.runRows(52);
    await again;
    expect(board.ended).toBe(60);
  });

  test("counts a row whose end was lost", async () => {
    const { board, done } = begun(3);
    await board.settle();
    board.begin();
    board.begin();
    expect(board.ended).toBe(1);
    board.end();
    board.begin();
    board.end();
    await done;
    expect(board.ended).toBe(3);
  });

  test("says where it is when the board starts again or a line is damaged", async () => {
    const { board, done } = begun(60);
    await board.settle();
    await board.runRows(2);
    board.isReady = false;
    board.streamer.giveUp("the board is starting");
    await done;
    expect(said.notices.at(-1)).toBe("long.txt: the board is starting; rows up to 2 of 60 have run");
    const other = begun(5);
    other.board.fails = "m3";
    await other.done;
    expect(said.notices.at(-1)).toBe('long.txt: "m3" came back as "m"; rows up to 0 of 5 have run');
    expect(other.board.typed.slice(-3)).toEqual(["l", "S", "$O0"]);
  });
});
