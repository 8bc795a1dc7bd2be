import { describe, expect, test } from "vitest";
import { FileRefusal } from "../src/views/companion/file_problem";
import { readOneShots, writeOneShots } from "../src/views/companion/oneshot_file";
import { readQueue, writeQueue } from "../src/views/companion/queue_file";
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
  rowsOfText,
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
import { readConfiguration, readListing, readSession, readSpeed } from "../src/views/companion/queue_screen";

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
const withLine = (number: number, text: string) => bytes(LINES.map((line, index) => `${index + 1 === number ? text : line}\r\n`).join(""));

function refusal(run: () => unknown): string[] {
  try {
    run();
  } catch (error) {
    if (error instanceof FileRefusal) return error.message.split("\n");
    throw error;
  }
  throw new Error("nothing was refused");
}

describe("queue files", () => {
  test("are written as they were read", () => {
    expect(writeQueue(readQueue(FILE, "q.txt").rows)).toEqual(FILE);
  });

  test("may be made by hand", () => {
    const text = LINES.join("\n").replaceAll(" ", "").replaceAll(",.5,", ",0.50,");
    expect(readQueue(bytes(text), "q.txt").rows).toEqual(readQueue(FILE, "q.txt").rows);
  });

  test("may have their rows in another order", () => {
    const swapped = bytes([LINES[1], LINES[0], ...LINES.slice(2)].map((line) => `${line}\r\n`).join(""));
    const read = readQueue(swapped, "q.txt");
    expect(read.rows).toEqual(readQueue(FILE, "q.txt").rows);
    expect(read.lines.slice(0, 3)).toEqual([2, 1, 3]);
  });

  const BAD: [string, string][] = [
    [" 3 , x , 0 , 1 , 150 , 2000 , 0 , 1 , 1 , 0 , 0 , 0 ", 'q.txt:3:6: steps is "x"; write a whole number'],
    [" 3 , 1.5 , 0 , 1 , 150 , 2000 , 0 , 1 , 1 , 0 , 0 , 0 ", 'q.txt:3:6: steps is "1.5"; write a whole number'],
    [" 3 , 5 , 2 , 1 , 150 , 2000 , 0 , 1 , 1 , 0 , 0 , 0 ", "q.txt:3:10: direction is 2; 1 is the largest"],
    [" 3 , 5 , 0 , 1 , 150 , 2000 , 0 , 1.234 , 1 , 0 , 0 , 0 ", "q.txt:3:35: acc is 1.234; a board keeps two decimals below 100, and none from there on"],
    [" 3 , 5 , 0 , 1 , 150 , 2000 , 0 , 100.5 , 1 , 0 , 0 , 0 ", "q.txt:3:35: acc is 100.5; a board keeps two decimals below 100, and none from there on"],
    [" 3 , 5 , 0 , 1 , 150 , 2000 , 0 , 1000 , 1 , 0 , 0 , 0 ", "q.txt:3:35: acc is 1000; 999 is the largest"],
    [" 3 , 5 , 0 , 1 , 150 , 2000 , 0 , 1 , 1 , 256 , 0 , 0 ", "q.txt:3:43: u is 256; 255 is the largest"],
    [" 3 , 5 , 0 , 1 , 150 , 2000 , 0 , 1 , 1 , 0 , 0 , 4294967296 ", "q.txt:3:51: deltaT is 4294967296; 4294967295 is the largest"],
    [" 3 , 0 , 0 , 1 , 150 , 2000 , 0 , 1 , 1 , 0 , 0 , 0 ", "q.txt:3:1: no steps; a queue holds no continuous motion"],
    [" 3 , 5 , 0 , 1 , 0 , 2000 , 0 , 1 , 1 , 0 , 0 , 0 ", "q.txt:3:1: RPM and cycle cannot be 0"],
    [" 0 , 5 , 0 , 1 , 1 , 2000 , 0 , 1 , 1 , 0 , 0 , 0 ", "q.txt:3:1: position 0 is not of the queue; positions are 1 to 30"],
    [" 2 , 5 , 0 , 1 , 1 , 2000 , 0 , 1 , 1 , 0 , 0 , 0 ", "q.txt:3:1: position 2 stands twice; a queue has each once"],
    [" 3 , 5 , 0", "q.txt:3:1: 3 numbers; a row has 12: position, steps, direction, full step, RPM, cycle, ramp, acc, dec, u, sync, deltaT"],
    ["", "q.txt:3:1: an empty line; take it out"],
    [" 3 , 5\u00e9 , 0 ", "q.txt:3:7: the byte 0xc3 is not ASCII text; take it out"],
  ];
  test.each(BAD)("tell the place: %s", (line, message) => {
    expect(refusal(() => readQueue(withLine(3, line), "q.txt"))[0]).toBe(message);
  });

  test("that are cut off are refused wherever the cut is, with line and column", () => {
    for (let length = 0; length < FILE.length - 3; length += 13) {
      const messages = refusal(() => readQueue(FILE.slice(0, length), "q.txt"));
      expect(messages[0]).toMatch(/^q\.txt:\d+:\d+: ./);
    }
    const within = refusal(() => readQueue(FILE.slice(0, FILE.length - 3), "q.txt"))[0];
    expect(within).toBe(`q.txt:30:${LINES[29]!.length}: the file ends in the middle of this row; it was cut off, copy it again`);
    const inRow2 = FILE.slice(0, bytes(`${LINES[0]}\r\n 2 , 60`).length);
    expect(refusal(() => readQueue(inRow2, "q.txt"))[0]).toBe("q.txt:2:8: the file ends in the middle of this row; it was cut off, copy it again");
    const after2 = FILE.slice(0, bytes(`${LINES[0]}\r\n${LINES[1]}\r\n`).length);
    expect(refusal(() => readQueue(after2, "q.txt"))[0]).toMatch(/^q\.txt:2:1: no row for position 3, 4,/);
  });

  test("without their last line end are whole", () => {
    expect(readQueue(FILE.slice(0, -2), "q.txt").rows).toHaveLength(30);
  });

  test("that are no such files are refused", () => {
    expect(refusal(() => readQueue(new Uint8Array(100_001), "q.txt"))[0]).toBe("q.txt:1:1: 100,001 bytes; a file of the companion has some thousand");
    expect(refusal(() => readQueue(new Uint8Array([0x89, 0x50, 0, 255]), "p.png"))).toHaveLength(3);
  });
});

describe("one-shot files", () => {
  const SHOTS = bytes(`xm1200v150ad\r\n\r\nv159\r\nxm400ads\r\n${"\r\n".repeat(95)}xm400v200\r\n`);

  test("are written as they were read", () => {
    const read = readOneShots(SHOTS, "o.txt");
    expect(read).toHaveLength(100);
    expect([read[0], read[1], read[2], read[99]]).toEqual(["xm1200v150ad", "", "v159", "xm400v200"]);
    expect(writeOneShots(read)).toEqual(SHOTS);
  });

  test("with fewer lines have empty slots behind", () => {
    expect(readOneShots(bytes("v1\r\nv2\r\n"), "o.txt").slice(0, 3)).toEqual(["v1", "v2", ""]);
  });

  test("that are cut off are refused with line and column", () => {
    const cut = SHOTS.slice(0, bytes("xm1200v150ad\r\n\r\nv15").length);
    expect(refusal(() => readOneShots(cut, "o.txt"))).toEqual(["o.txt:3:4: the file ends in the middle of one-shot 3; it was cut off, copy it again"]);
    expect(refusal(() => readOneShots(bytes(""), "o.txt"))).toEqual(["o.txt:1:1: the file is empty"]);
  });

  test("with lines that no board takes are refused", () => {
    expect(refusal(() => readOneShots(bytes(`v1\r\n${"m".repeat(81)}\r\n`), "o.txt"))).toEqual(["o.txt:2:81: 81 characters; a board takes 80 a line"]);
    expect(refusal(() => readOneShots(bytes(`${"\r\n".repeat(100)}v1\r\n`), "o.txt"))[0]).toMatch(/^o\.txt:101:1: /);
    expect(refusal(() => readOneShots(bytes("v\x1b[2J\r\n"), "o.txt"))[0]).toMatch(/^o\.txt:1:2: the byte 0x1b/);
  });
});

describe("rows", () => {
  const [one, , , four, five] = readQueue(FILE, "q.txt").rows as [QueueRow, QueueRow, QueueRow, QueueRow, QueueRow];

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
    expect(cell("extra_pulses", "256")).toBe("u is 256; 255 is the largest");
    expect(cell("wait_us", "1e3")).toBe('deltaT is "1e3"; write a whole number');
    expect(cellText(cell("steps", "-300") as QueueRow, "steps")).toBe("-300");
    expect(cellText(four, "acc")).toBe("0.5");
  });
});

describe("the editor", () => {
  const rows = readQueue(FILE, "q.txt").rows;
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

  test("copies rows as text, and takes them back from it or from a spreadsheet", () => {
    const text = copiedText(loaded, 4, 5);
    expect(text).toBe(`${LINES[3]}\r\n${LINES[4]}\r\n`);
    expect(rowsOfText(text).rows).toEqual(rows.slice(3, 5));
    expect(rowsOfText(text.replaceAll(" , ", "\t")).rows).toEqual(rows.slice(3, 5));
    expect(rowsOfText("hello").problems[0]).toMatch(/^line 1, column 1: 1 numbers/);
    expect(rowsOfText(" \n").problems).toEqual(["there are no rows in the clipboard"]);
  });
});

describe("screens", () => {
  const RULE = "=".repeat(70);
  const listing = (last: string) => [
    "Q\tSteps\t\tRPM\tCycle\t Acc\tDec\tusteps\t deltaT",
    RULE,
    "1\t800\t CW\t150\t2000\t 1.00\t1.00\t0\t  3000",
    "2\t600\t+CCW\t69\t4321\t*10.47\t0.50\t255\ts 4294967295",
    ...Array.from({ length: 28 }, (_, index) => `${index + 3}\t200\t CW\t100\t3000\t 1.00\t1.00\t0\t  0`),
    RULE,
    last,
  ];

  test("the listing is read", () => {
    const read = readListing(listing("Q is at 7\t+ pulse \t\t* linear\t\ts sync"));
    if (typeof read === "string") throw new Error(read);
    expect(read.at).toBe(7);
    expect(read.rows).toHaveLength(30);
    expect(read.rows[1]).toEqual({
      steps: 600,
      is_ccw: true,
      is_full: false,
      rpm: 69,
      cycle_us: 4321,
      is_linear: true,
      acc_hundredths: 1047,
      dec_hundredths: 50,
      extra_pulses: 255,
      is_sync: true,
      wait_us: 4294967295,
    });
  });

  test("debug's first entry is passed over, and a gap is told", () => {
    const lines = listing("Q is at 1\t+ pulse \t\t* linear\t\ts sync");
    expect(readListing([lines[0]!, RULE, lines[4]!.replace(/^3/, "0"), ...lines.slice(2)])).toMatchObject({ at: 1 });
    expect(readListing(lines.filter((line) => !line.startsWith("5\t")))).toBe("row 5 is missing in the listing");
    expect(readListing(lines.slice(0, 20))).toMatch(/^the listing has 18 rows/);
    expect(readListing(lines.slice(0, -1))).toBe("the listing does not say where the queue is");
  });

  test("configuration, session and speed are read", () => {
    const screen = [
      "Config:",
      "A autorun\t0\ta sprf\t\t400",
      "E network\t0\te dec\t\t1.00",
      "H ihd\t\t8\th ops\t\t100100",
      "I xclk\t\t3\ti soft_ops\t0",
      "J ustep\t\t2\tj ACK\t\t1",
      "L slow\t\t10",
    ];
    expect(readConfiguration(screen)).toEqual({
      steps_per_rev: 400,
      microstep_exponent: 2,
      interrupt_overhead_us: 8,
      clock_correction_us: 3,
      slow_rpm: 10,
      is_network_swapped: false,
    });
    expect(readConfiguration(["login:"])).toBeUndefined();
    expect(readSession(["v\t100", "soft_ops\t1", "?"]).get("soft_ops")).toBe("1");
    expect(readSpeed(["150\t2000"])).toEqual({ rpm: 150, period_us: 2000 });
    expect(readSpeed(["what"])).toBeUndefined();
  });
});
