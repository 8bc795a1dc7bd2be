import { describe, expect, it } from "vitest";
import { angleAt, laneOf, lineOfStep, pathOf, rangeOf, readPlan } from "../src/model/run_plan";

const TOLD = {
  duration_s: 4,
  is_exact: true,
  axes: { m1: { at_s: [0, 2, 4], position_deg: [0, 90, 90] } },
  steps: [
    [0, 2, 1, "move m1 90"],
    [2, 2, 2, "pins m1.D3 1"],
    [2, 4, 3, "dwell_s 2"],
  ],
  steps_left_out: 0,
};

describe("the plan of a run", () => {
  it("is read, and what is none is none", () => {
    const plan = readPlan(TOLD)!;
    expect(plan.steps[1]).toEqual({ from_s: 2, to_s: 2, number: 2, text: "pins m1.D3 1" });
    expect(plan.axes[0]?.name).toBe("m1");
    for (const raw of [null, undefined, {}, [], "x", { duration_s: "3" }]) expect(readPlan(raw)).toBeNull();
    expect(readPlan({ duration_s: 1, axes: { m1: null }, steps: [null, 3] })?.axes).toEqual([{ name: "m1", at_s: [], position_deg: [] }]);
  });
  it("is drawn in a box", () => {
    const { axes } = readPlan(TOLD)!;
    expect(rangeOf(axes)).toEqual([-4.5, 94.5]);
    expect(rangeOf([])).toEqual([-1, 1]);
    expect(pathOf(axes[0]!, 4, [0, 90], 100, 50)).toBe("M0.0 50.0L50.0 0.0L100.0 0.0");
    expect(pathOf({ name: "x", at_s: [], position_deg: [] }, 0, [0, 1], 100, 50)).toBe("");
  });
  it("has an angle at each time", () => {
    const [axis] = readPlan(TOLD)!.axes;
    expect([-1, 0, 1, 2, 3, 9].map((at_s) => angleAt(axis!, at_s))).toEqual([0, 0, 45, 90, 90, 90]);
  });
  it("has lanes in which steps do not cover each other", () => {
    expect(laneOf(readPlan(TOLD)!.steps, 0.1, 3)).toEqual([0, 0, 1]);
    expect(laneOf(Array(5).fill({ from_s: 0, to_s: 0, number: 1, text: "" }), 1, 3)).toEqual([0, 1, 2, 2, 2]);
  });
  it("leads to the lines of its steps", () => {
    const text = "run: r\naxes: {m1: {}}\nsteps:\n- move:\n    m1: 3\n# - no\n- path:\n    axes:\n    - m1\n- dwell_s: 1\n";
    expect([1, 2, 3, 4].map((number) => lineOfStep(text, number))).toEqual([4, 7, 10, 0]);
    expect(lineOfStep('{"run": "r", "steps": []}', 1)).toBe(0);
  });
});
