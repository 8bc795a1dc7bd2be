import { expect, test } from "vitest";
import { agoText, markBeside, readMarks, readRows, ticks, timeText } from "../src/model/past";

test("times are told as people say them", () => {
  expect(timeText(723.25)).toBe("00:12:03.250");
  expect(timeText(36_000.0004)).toBe("10:00:00.000");
  expect(timeText(59.9996)).toBe("00:01:00.000");
  expect(timeText(-1)).toBe("00:00:00.000");
  expect([0, 12.52, 200, 7500].map(agoText)).toEqual(["0.0 s", "12.5 s", "3 min 20 s", "2 h 5 min"]);
});

test("marks are read, and what is none is left out", () => {
  const lasting = { lane: "faults", from_ns: 1_500_000_000, to_ns: null, of: "m1", text: "shaft_load" };
  expect(readMarks([lasting, null, 7, { lane: "verbs" }])).toEqual([{ lane: "faults", from_s: 1.5, to_s: null, of: "m1", text: "shaft_load" }]);
  expect(readMarks("no")).toEqual([]);
});

test("rows are numbers of 64 bits", () => {
  const rows = new Float64Array([0.5, -1.25, Number.NaN]);
  const text = btoa(String.fromCharCode(...new Uint8Array(rows.buffer)));
  expect(readRows(text)).toEqual(rows);
  expect(readRows("")).toHaveLength(0);
});

test("the mark beside a time is the next or the last, whatever their order", () => {
  const marks = [3, 1, 2].map((from_s) => ({ lane: "verbs", from_s, to_s: from_s, of: "m1", text: "" }));
  expect(markBeside(marks, 1, false)?.from_s).toBe(2);
  expect(markBeside(marks, 2, true)?.from_s).toBe(1);
  expect(markBeside(marks, 2.5, true)?.from_s).toBe(2);
  expect(markBeside(marks, 3, false)).toBeUndefined();
  expect(markBeside(marks, 1, true)).toBeUndefined();
});

test("ticks stand at round times, and are not too many", () => {
  expect(ticks(0, 100, 10)).toEqual([0, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100]);
  expect(ticks(1.25, 1.26, 6).map((at) => at.toFixed(3))).toEqual(["1.250", "1.252", "1.254", "1.256", "1.258", "1.260"]);
  expect(ticks(0, 1e7, 8).length).toBeLessThan(10);
});
