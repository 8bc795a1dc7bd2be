import { describe, expect, it } from "vitest";
import lines from "../../hil/sketch/tests/printed_lines.json";
import { MOST_NAMES, numbersIn, PrintedNumbers } from "../src/model/printed_numbers";

/** Lines that `hil sketch plot` reads in the same way. */
const LINES = lines as unknown as [string, Record<string, number>][];
const piece = (at_s: number, text: string) => ({ at_s, bytes: new TextEncoder().encode(text) });

describe("numbers of a line", () => {
  it.each(LINES)("%j", (line, wanted) => {
    expect(Object.fromEntries(numbersIn(line))).toEqual(wanted);
  });
});

describe("numbers that a board prints", () => {
  it("begin with the first whole line", () => {
    const numbers = new PrintedNumbers();
    for (const [at, text] of ["7\n1", "0\nready\n20", "\r\n\n"].entries()) numbers.add(piece(at, text));
    expect([numbers.times_s, numbers.columns, numbers.others]).toEqual([[1, 2], [[10, 20]], 1]);
  });

  it("have a latest value for each name, and none before its first", () => {
    const numbers = new PrintedNumbers();
    numbers.add(piece(5, "\na:1\nb:2\na:3\n"));
    expect(numbers.columns).toEqual([
      [1, 1, 3],
      [NaN, 2, 2],
    ]);
    expect(numbers.csv()).toBe("at_s,a,b\n5,1,\n5,1,2\n5,3,2\n");
  });

  it("keep the newest of what comes without end, and no names without end", () => {
    const numbers = new PrintedNumbers();
    numbers.add(piece(0, `\n${"1\n".repeat(20_001)}`));
    expect(numbers.times_s.length).toBe(18_001);
    numbers.add(piece(1, Array.from({ length: MOST_NAMES + 5 }, (_, at) => `n${at}:1\n`).join("")));
    expect(numbers.names.length).toBe(MOST_NAMES);
    numbers.add(piece(2, `${"1".repeat(2000)}`));
    numbers.add(piece(2, "9\n5\n"));
    expect(numbers.columns[0]?.at(-1)).toBe(5);
  });
});
