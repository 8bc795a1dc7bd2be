import { describe, expect, it } from "vitest";
import { check, checkAll, limitsOf } from "../src/model/parameters";
import { byteRate, plain, shown } from "../src/model/numbers";
import { readProblems } from "../src/model/problems";

const ANGLE = { name: "position_deg", unit: "deg", minimum: -360, maximum: 360, default: null };

describe("check", () => {
  it.each(["0", "-360", "360", "1e2", ".5", "+3", "−90", " 7 "])("takes the number %j", (typed) => {
    expect(check(ANGLE, typed)).toHaveProperty("value");
  });

  it.each(["361", "-361", "", "x", "0x10", "1,5", "Infinity", "NaN", "1 2"])("refuses %j", (typed) => {
    expect(check(ANGLE, typed)).toHaveProperty("problem");
  });

  it("says the limits in the unit", () => {
    expect(check(ANGLE, "400")).toEqual({ problem: "write -360 to 360 deg" });
    expect(limitsOf({ name: "torque_Nm", unit: "Nm", limits: "-10 to 10 times what the motor holds" })).toContain("in Nm");
  });

  it("leaves out what may be left out, and asks for the rest", () => {
    const rows = [{ ...ANGLE }, { name: "seed", default: 0, type: "whole" as const, maximum: 9 }, { name: "coil", choices: ["A", "B"], default: "A" }];
    expect(checkAll(rows, { position_deg: "1", seed: "" })).toEqual({ values: { position_deg: 1 }, problems: {} });
    expect(Object.keys(checkAll(rows, { seed: "1.5", coil: "C" }).problems)).toEqual(["position_deg", "seed", "coil"]);
  });

  it("counts characters, not code units", () => {
    expect(check({ name: "t", type: "text" as const, maximum: 2 }, "😀😀")).toEqual({ value: "😀😀" });
    expect(check({ name: "t", type: "text" as const, maximum: 2 }, "abc")).toHaveProperty("problem");
  });
});

describe("numbers", () => {
  it("are shown for people", () => {
    expect([shown(-0.001, 2), shown(NaN), shown(null), shown(-1.5, 1), shown(-Infinity)]).toEqual(["0.00", "–", "–", "−1.5", "−∞"]);
    expect([plain(1e6), plain(0.001), plain(1e18)]).toEqual(["1000000", "0.001", "1000000000000000000"]);
    expect([byteRate(0), byteRate(12.4), byteRate(11520), byteRate(3e6)]).toEqual(["0 B/s", "12 B/s", "11.5 kB/s", "3.0 MB/s"]);
  });
});

describe("problems of a document", () => {
  it("have line and column, and keep what continues them", () => {
    const told = "a:b.yaml:6:16: steps.0: no\n    6 |  x\n      | ^\nwhole file: too long";
    expect(readProblems(told)).toEqual([
      { line: 6, column: 16, text: "steps.0: no\n    6 |  x\n      | ^" },
      { line: 0, column: 0, text: "whole file: too long" },
    ]);
    expect(readProblems([{ line: 2, column: 3, message: "x" }])).toEqual([{ line: 2, column: 3, text: "x" }]);
    expect(readProblems(undefined)).toEqual([]);
  });
});
