import { describe, expect, it } from "vitest";
import { decoded, lineAt, partOf, pointsOf, readDrawing, shareDone } from "../src/model/drawing";
import { PathDeviation } from "../src/model/path_deviation";

const ANSWER = {
  problems: [],
  remarks: ["p:2:1: too fast (slower)"],
  machine: "mill",
  figures: { lines: 5, duration_s: 3, feed_mm: 20, rapid_mm: 10, range: { x: [0, 10] } },
  axes: [
    { letter: "x", axis: "m1", unit: "mm", deg_per_unit: 9, zero_deg: 0 },
    { letter: "y", axis: "m2", unit: "mm", deg_per_unit: -9, zero_deg: 5 },
  ],
  path: { places: [0, 0, 10, 0, 10, 10, 0, 10, 0, 0], count: 5, rapids: [[1, 2]], lines: [[1, 2], [2, 3], [3, 5]], is_whole: true },
  runs: [
    { text: "{}", duration_s: 1, timeline: [[0, 2]], pause_line: 2 },
    { text: "{}", duration_s: 2, timeline: [[0, 3], [1.5, 5]], pause_line: null },
  ],
};

describe("a drawing", () => {
  const made = readDrawing(ANSWER);
  if (!made || "problems" in made) throw new Error("no drawing");

  it("is read", () => {
    expect(made.count).toBe(5);
    expect(made.remarks).toEqual([{ line: 2, column: 1, text: "too fast (slower)" }]);
    expect(made.figures.range).toEqual([["x", 0, 10]]);
    expect(made.text).toBeNull();
  });

  it("has problems instead", () => {
    expect(readDrawing({ problems: ["p:1:2: what (this)"], of: "machine" })).toEqual({ of: "machine", problems: [{ line: 1, column: 2, text: "what (this)" }] });
  });

  it.each([null, 3, [], {}, { axes: [1] }, { axes: [{}], path: 3 }, "x"])("is none: %j", (raw) => {
    expect(readDrawing(raw)).toBeNull();
  });

  it("knows its runs by their names", () => {
    expect(["mill", "mill-2", "mill_1", "mill_2-7", "mill_x", "other", "mil_1x"].map((name) => partOf(name, "mill"))).toEqual([0, 0, 0, 1, null, null, null]);
  });

  it("tells the line and the share", () => {
    expect(lineAt(made.parts[1]!, 1.4)).toBe(3);
    expect(lineAt(made.parts[1]!, 1.6)).toBe(5);
    expect(shareDone(made.parts, 1, 0.5)).toBeCloseTo(0.5);
    expect(shareDone(made.parts, 0, 9)).toBe(1);
    expect(pointsOf(made, 3)).toEqual([1, 3]);
    expect(pointsOf(made, 99)).toEqual([0, 5]);
  });
});

describe("a deviation", () => {
  const square = Float64Array.from(ANSWER.path.places);

  it("is the distance from the path, in its order", () => {
    const off = new PathDeviation(square, 2);
    expect(off.take([0, 0.5])).toBeCloseTo(0.5);
    for (let x = 1; x < 10; x++) expect(off.take([x, 0.1])).toBeCloseTo(0.1);
    for (let y = 1; y < 10; y++) expect(off.take([10.2, y])).toBeCloseTo(0.2);
    expect(off.largest).toBeCloseTo(0.5);
  });

  it("begins where the machine is", () => {
    const off = new PathDeviation(square, 2, 3, 5);
    expect(off.take([0, 7])).toBeCloseTo(0);
    expect(off.take([0, 6])).toBeCloseTo(0);
  });

  it("is 0 of no path", () => {
    expect(new PathDeviation(new Float64Array(2), 2).take([3, 4])).toBe(0);
  });
});

describe("bytes of a file", () => {
  const text = "G0 X1 (µ)";
  const utf16 = Uint8Array.from([0xff, 0xfe, ...[...text].flatMap((each) => [each.charCodeAt(0), 0])]);
  it.each([new TextEncoder().encode(text), utf16, Uint8Array.from([...text].map((each) => each.charCodeAt(0)))])("are its text", (bytes) => {
    expect(decoded(bytes)).toBe(text);
  });
});
