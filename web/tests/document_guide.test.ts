import { describe, expect, it } from "vitest";
import { explained, offersAt, runAxes } from "../src/model/document_guide";
import type { DeviceRow } from "../src/model/door";
import { exampleMachine, exampleRun } from "../src/model/run_example";
import { placeAtEnd } from "../src/model/yaml_place";

const rpm = (minimum: number, maximum: number) => ({
  name: "velocity_rpm",
  summary: "",
  unit: "rpm",
  type: "number" as const,
  minimum,
  maximum,
  default: null,
  is_optional: false,
  text: "",
});
const device = (name: string, verbs: DeviceRow["verbs"], more: Partial<DeviceRow> = {}): DeviceRow => ({
  name,
  profile: name.startsWith("s") ? "sac" : "mechaduino",
  is_real: false,
  is_seen: true,
  verbs,
  fields: [{ name: "position_deg", type: "float", unit: "deg", meaning: "angle of the shaft", is_settable: false, is_state: true }],
  inputs: { D3: "" },
  ...more,
});
const verb = (...parameters: ReturnType<typeof rpm>[]) => ({ summary: "", role: "operator" as const, parameters });
const BENCH = [
  device("m1", { stop: verb(), position: verb(), move_abs: verb(rpm(1, 900)) }),
  device("s1", { stop: verb(), move_abs: verb(rpm(1, 700)) }),
  device("u1", { reset: verb() }),
];
const offered = (before: string, kind: "RunDocument" | "MachineText" = "RunDocument") =>
  offersAt(kind, placeAtEnd(before), BENCH).map(({ name, insert, detail }) => insert ?? `${name} ${detail}`);

describe("places in a document", () => {
  it.each([
    ["", [], null, ""],
    ["ru", [], null, "ru"],
    ["run: ex", [], "run", "ex"],
    ["axes:\n  ", ["axes"], null, ""],
    ["axes:\n  m1:\n    vel", ["axes", "m1"], null, "vel"],
    ["axes:\n  m1: {vel", ["axes", "m1"], null, "vel"],
    ["axes:\n  m1: {velocity_rpm: 6", ["axes", "m1"], "velocity_rpm", "6"],
    ["axes:\n  m1: {velocity_rpm: 6, ", ["axes", "m1"], null, ""],
    ["axes:\n  m1: {}\nsteps:\n- mo", ["steps"], null, "mo"],
    ["steps:\n- move: {m1: 4}\n  in", ["steps"], null, "in"],
    ["steps:\n- move: {m1: 4}\n- dwell_s: ", ["steps"], "dwell_s", ""],
    ["steps:\n  - move:\n      m1: 4\n  - ", ["steps"], null, ""],
    ["steps:\n- path: {axes: [m1, ", ["steps", "path", "axes"], null, ""],
    ["steps:\n- spline:\n  - {at_s: 1, ", ["steps", "spline"], null, ""],
    ["# run: {\nrun: a # {\nax", [], null, "ax"],
    ['run: "a: {"\nax', [], null, "ax"],
  ])("%j", (before, path, key, typed) => {
    expect(placeAtEnd(before)).toMatchObject({ path, key, typed });
  });
});

describe("what may stand there", () => {
  it("is what the document has", () => {
    expect(offered("")).toEqual(["run: ", "axes: ", "profile: ", "on_fault: ", "silence_s: ", "start_in_s: ", "steps: "]);
    expect(offered("profile: ")).toEqual(["trapezoid ", "s_curve as if left out"]);
    expect(offered("steps:\n- ")).toContain("wait_until: ");
    expect(offered("nonsense:\n  ")).toEqual([]);
    expect(offered("axes:\n  x: {", "MachineText")).toContain("deg_per_mm: ");
  });
  it("is what the bench has", () => {
    expect(offered("axes:\n  ")).toEqual(["m1: ", "s1: "]);
    expect(offered("steps:\n- move: ")).toEqual(["{m1: 0}", "{s1: 0}"]);
    expect(offered("steps:\n- move: {")).toEqual(["m1: ", "s1: "]);
    expect(offered("steps:\n- wait_until: {axis: ")).toEqual(["m1", "s1"]);
    expect(offered("steps:\n- wait_until: {field: ")).toEqual(["position_deg deg"]);
    expect(offered("steps:\n- pins: {")).toEqual(["m1.D3: ", "s1.D3: "]);
    expect(offered("steps:\n- path: {axes: [")).toEqual(["m1", "s1"]);
    expect(offered("axes:\n  x: {axis: ", "MachineText")).toEqual(["m1", "s1"]);
  });
  it("has limits with their units, and those of the very board", () => {
    expect(offered("axes:\n  s1: {velocity_rpm: ")).toEqual(["60 rpm, as if left out", "700 rpm, the most that s1 takes"]);
    expect(offered("axes:\n  m1: {velocity_rpm: ")).toEqual(["60 rpm, as if left out", "3000 rpm, the most"]);
    expect(explained("RunDocument", placeAtEnd("axes:\n  s1: {"), "velocity_rpm", BENCH)).toContain("(0 to 3000 rpm; s1 takes 1 to 700 rpm)");
    expect(explained("RunDocument", placeAtEnd("steps:\n- "), "dwell_s", BENCH)).toBe("dwell_s: Pause of all axes. (0 to 86400 s)");
    expect(explained("RunDocument", placeAtEnd("axes:\n  "), "m1", BENCH)).toBe("m1: axis of this bench, a mechaduino");
    expect(explained("RunDocument", placeAtEnd("steps:\n- "), "nothing", BENCH)).toBe("");
  });
});

it("begins with a run of the bench's own axes", () => {
  expect(runAxes(BENCH).map(({ name }) => name)).toEqual(["m1", "s1"]);
  expect(exampleRun(BENCH)).toContain("- move_by: {m1: 90, s1: -90}\n");
  expect(exampleRun([])).toBe("run: example\naxes:\nsteps:\n");
  expect(exampleMachine(BENCH)).toContain("axes:\n  x: {axis: m1, deg_per_mm: 9, ");
  expect(exampleMachine(BENCH.slice(1))).toBe("");
});
