import { describe, expect, test } from "vitest";
import { writeOneShots } from "../src/views/companion/oneshot_file";
import { writeQueue } from "../src/views/companion/queue_file";
import {
  changed,
  cleared,
  copiedText,
  deleted,
  inserted,
  moved,
  newQueue,
  pasted,
  redone,
  replacedByBoard,
  seenOnBoard,
  sentToBoard,
  setRow,
  undone,
  unsent,
  withCell,
  cellText,
  type QueueState,
} from "../src/views/companion/queue_model";
import { decimal, isPossible, rowCommand, seedRow, type QueueRow } from "../src/views/companion/queue_row";

// Rows in the form in which the companion program saves them.
const FORM = [
  " 1 , 800 , 0 , 1 , 150 , 2000 , 0 , 1 , 1 , 0 , 0 , 3000 ",
  " 2 , 600 , 1 , 1 , 50 , 6000 , 0 , 1 , 1 , 0 , 0 , 3000 ",
  " 3 , 2000 , 1 , 1 , 100 , 3000 , 1 , 10.47 , 10.47 , 0 , 0 , 0 ",
  " 4 , 10 , 0 , 1 , 69 , 4321 , 0 , .5 , 999 , 0 , 0 , 2400000 ",
  " 5 , 200 , 0 , 0 , 999 , 300 , 1 , .05 , 12.3 , 255 , 1 , 4294967295 ",
];
const LINES = [...FORM, ...Array.from({ length: 25 }, (_, index) => ` ${index + 6} , 200 , 0 , 1 , 100 , 3000 , 0 , 1 , 1 , 0 , 0 , 0 `)];
const bytes = (text: string) => new TextEncoder().encode(text);
const FILE = bytes(LINES.map((line) => `${line}\r\n`).join(""));
const ROWS: QueueRow[] = LINES.map((line) => {
  const [, steps, ccw, full, rpm, cycle_us, linear, acc, dec, extra_pulses, sync, wait_us] = line.split(",").map(Number) as number[];
  const [is_ccw, is_full, is_linear, is_sync] = [ccw, full, linear, sync].map(Boolean);
  const [acc_hundredths, dec_hundredths] = [acc, dec].map((value) => Math.round(value! * 100));
  return { steps, is_ccw, is_full, rpm, cycle_us, is_linear, acc_hundredths, dec_hundredths, extra_pulses, is_sync, wait_us } as QueueRow;
});

describe("files", () => {
  test("are written as the companion does", () => {
    expect(writeQueue(ROWS)).toEqual(FILE);
    const shots = ["xm1200v150ad", "", "v159", ...Array.from({ length: 96 }, () => ""), "xm400v200"];
    expect(writeOneShots(shots)).toEqual(bytes(`xm1200v150ad\r\n\r\nv159\r\n${"\r\n".repeat(96)}xm400v200\r\n`));
  });
});

describe("rows", () => {
  const [one, , , four, five] = ROWS as [QueueRow, QueueRow, QueueRow, QueueRow, QueueRow];

  test("are typed as the board takes them", () => {
    expect(rowCommand(1, one, 200)).toBe("q1m800v150a1d1l0fu0s0t3000");
    expect(rowCommand(4, four, 200)).toBe("q4m10vc4321a.5d999l0fu0s0t2400000");
    expect(rowCommand(5, { ...five, is_ccw: true }, 200)).toBe("q5m-200v999a.05d12.3l1pu255s1t4294967295");
  });

  test("may contradict themselves", () => {
    expect(isPossible(four, 200)).toBe(true);
    expect(isPossible({ ...four, cycle_us: 9999 }, 200)).toBe(false);
  });

  test("have decimals as the files", () => {
    expect([0, 1, 50, 100, 1047, 1050, 10000, 99900].map(decimal)).toEqual(["0", ".01", ".5", "1", "10.47", "10.5", "100", "999"]);
  });

  test("take numbers within their limits", () => {
    const cell = (name: Parameters<typeof withCell>[1], text: string) => withCell(one, name, text, 200);
    expect(cell("steps", "-300")).toMatchObject({ steps: 300, is_ccw: true });
    expect(cell("steps", "0")).toBe("steps is 0; a queue holds no continuous motion");
    expect(cell("steps", "4294967296")).toBe("steps is 4294967296; 4294967295 is the largest");
    expect(cell("rpm", "70")).toMatchObject({ rpm: 70, cycle_us: 4285 });
    expect(cell("rpm", "0")).toBe("RPM is 0; 1 is the least");
    expect(cell("rpm", "150001")).toBe("RPM is 150001; 150000 is the most at 200 steps a turn");
    expect(cell("cycle_us", "4321")).toMatchObject({ rpm: 69, cycle_us: 4321 });
    expect(cell("cycle_us", "1")).toBe("cycle is 1; 2 us is the least");
    expect(cell("cycle_us", "300001")).toBe("cycle is 300001; that is less than 1 RPM");
    expect(cell("acc", ".5")).toMatchObject({ acc_hundredths: 50 });
    expect(cell("dec", "1000")).toBe("dec is 1000; 999 is the largest");
    expect(cell("acc", "1.234")).toBe("acc is 1.234; a board keeps two decimals below 100, and none from there on");
    expect(cell("acc", "100.5")).toBe("acc is 100.5; a board keeps two decimals below 100, and none from there on");
    expect(cell("acc", "100.0")).toMatchObject({ acc_hundredths: 10000 });
    expect(cell("steps", "1.5")).toBe('steps is "1.5"; write a whole number');
    expect(cell("extra_pulses", "256")).toBe("u is 256; 255 is the largest");
    expect(cell("wait_us", "1e3")).toBe('deltaT is "1e3"; write a whole number');
    expect(cellText(cell("steps", "-300") as QueueRow, "steps")).toBe("-300");
    expect(cellText(four, "acc")).toBe("0.5");
  });
});

describe("the editor", () => {
  const rows = ROWS;
  const loaded: QueueState = changed(newQueue(), rows);
  const steps = (state: QueueState, count = 6) => state.rows.slice(0, count).map((row) => row.steps);

  test("inserts, deletes, moves and pastes, always 30 rows", () => {
    const seed = seedRow(200);
    expect(steps(inserted(loaded, 2, [seed]))).toEqual([800, 200, 600, 2000, 10, 200]);
    expect(steps(deleted(loaded, 1, 2), 3)).toEqual([2000, 10, 200]);
    expect(steps(moved(loaded, 1, 2, 3))).toEqual([2000, 10, 800, 600, 200, 200]);
    expect(
      moved(loaded, 1, 2, 99)
        .rows.slice(28)
        .map((row) => row.steps),
    ).toEqual([800, 600]);
    expect(steps(moved(loaded, 3, 3, 2))).toEqual([800, 2000, 600, 10, 200, 200]);
    expect(steps(pasted(loaded, 3, rows.slice(0, 2)))).toEqual([800, 600, 800, 600, 200, 200]);
    expect(steps(pasted(loaded, 30, rows.slice(0, 2)))).toEqual(steps(loaded));
    for (const state of [inserted(loaded, 30, rows), deleted(loaded, 1, 30), pasted(loaded, 20, rows), cleared(loaded)]) {
      expect(state.rows).toHaveLength(30);
    }
  });

  test("undoes and redoes", () => {
    const once = deleted(loaded, 1, 1);
    const twice = setRow(once, 1, { ...once.rows[0]!, steps: 7 });
    expect(undone(undone(twice)).rows).toEqual(loaded.rows);
    expect(redone(redone(undone(undone(twice)))).rows).toEqual(twice.rows);
    expect(redone(setRow(undone(twice), 5, { ...rows[0]!, steps: 9 })).rows[0]!.steps).toBe(once.rows[0]!.steps);
    expect(undone(newQueue()).rows).toEqual(newQueue().rows);
    expect(setRow(loaded, 1, rows[0]!)).toBe(loaded);
  });

  test("knows what the board does not have yet, and keeps it when it looks again", () => {
    const online = replacedByBoard(newQueue(), rows, 200);
    expect(unsent(online)).toEqual([]);
    const edited = setRow(online, 3, { ...rows[2]!, steps: 77 });
    expect(unsent(edited)).toEqual([3]);
    const other = rows.map((row, index) => (index === 4 ? { ...row, steps: 55 } : row));
    const seen = seenOnBoard(edited, other, 200);
    expect([seen.rows[2]!.steps, seen.rows[4]!.steps, unsent(seen)]).toEqual([77, 55, [3]]);
    expect(unsent(sentToBoard(seen, 3, seen.rows[2]!))).toEqual([]);
    expect(unsent(newQueue())).toHaveLength(30);
  });

  test("copies rows as text", () => {
    expect(copiedText(loaded, 4, 5)).toBe(`${LINES[3]}\r\n${LINES[4]}\r\n`);
  });
});
