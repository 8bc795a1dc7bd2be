import { describe, expect, it } from "vitest";
import { checkStep } from "../src/model/step_form";

describe("a step that is typed", () => {
  it.each([
    ["10", "0.5", 10, 0.5, {}],
    ["-3.5", "1", -3.5, 1, {}],
    ["", "", 10, 0.5, {}],
    ["0", "0.5", 0, 0.5, { step_deg: "0 deg is no step" }],
    ["-0.0", "0.5", -0, 0.5, { step_deg: "0 deg is no step" }],
  ])("%j for %j", (step_deg, length_s, far, long, problems) => {
    expect(checkStep({ step_deg, length_s })).toEqual({ step_deg: far, length_s: long, problems });
  });

  it.each(["x", "1e9", "NaN", "1,5"])("%j is told why", (step_deg) => {
    expect(checkStep({ step_deg, length_s: "0.5" }).problems["step_deg"]).toMatch(/^write/);
  });
});
