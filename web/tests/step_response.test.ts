import { describe, expect, it } from "vitest";
import cases from "../../hil/telemetry/tests/step_cases.json";
import { otherMotion, stepFigures } from "../src/model/step_response";
import { differenceOf, responsesCsv } from "../src/model/step_table";

const NEAR = 6;

function near(is: number, wanted: number | null): void {
  if (wanted === null) expect(is).toBeNaN();
  else expect(is).toBeCloseTo(wanted, NEAR);
}

describe("figures of a step, as hil step computes them", () => {
  it.each(cases)("$about", ({ at_ms, set_point, position, rise_ms, overshoot_pct, settling_ms, final_error }) => {
    const figures = stepFigures({ times_s: at_ms.map((at) => at / 1000), setpoint: set_point, position });
    near(figures.rise_s * 1000, rise_ms);
    expect(figures.overshoot_percent).toBeCloseTo(overshoot_pct, NEAR);
    near(figures.settling_s * 1000, settling_ms);
    expect(figures.final_error).toBeCloseTo(final_error, NEAR);
  });

  it("has none where nothing steps", () => {
    expect(stepFigures({ times_s: [0, 1], setpoint: [0, 0], position: [0, 0] }).rise_s).toBeNaN();
    expect(stepFigures({ times_s: [], setpoint: [], position: [] }).final_error).toBeNaN();
  });
});

describe("a step that is none", () => {
  const of = (...setpoint: number[]) => otherMotion({ times_s: setpoint.map((_, at) => at), setpoint, position: setpoint }, 10, 10);

  it.each([
    [[0, 0, 10, 10], ""],
    [[0, 0, 4, 4], "did not get there"],
    [[0, 10, 10, 9.97], "moved on"],
    [[0, 10, 20], "moved on"],
  ])("%j", (setpoint, why) => {
    const told = of(...setpoint);
    if (why) expect(told).toContain(why);
    else expect(told).toBe("");
  });
});

describe("two responses", () => {
  const response = (rise_s: number, gains: Record<string, number>) => ({
    rows: { times_s: [-0.25, 0], setpoint: [0, 10], position: [0, 1] },
    figures: { rise_s, overshoot_percent: 10 * rise_s, settling_s: NaN, final_error: 0.5 },
    gains,
  });
  const before = response(1, { pKp: Math.fround(15.1), pKi: 0.2 });
  const after = response(3, { pKp: 15.1, pKi: 0.25 });

  it("differ by figures and gains", () => {
    expect(differenceOf(before, after)).toEqual({
      rise_ms: 2000,
      overshoot: 20,
      settling_ms: NaN,
      error_deg: 0,
      gains: [{ name: "pKi", was: 0.2, is: 0.25 }],
    });
  });

  it("are one table", () => {
    expect(responsesCsv({ before: null, after })).toBe("response,at_s,set_point_deg,position_deg\nafter,-0.25,0,0\nafter,0,10,1\n");
    expect(responsesCsv({ before, after }).split("\n")).toHaveLength(6);
  });
});
