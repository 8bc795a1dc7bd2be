import { describe, expect, it } from "vitest";
import { readFaults } from "../src/model/fault_marks";
import { plain } from "../src/model/numbers";
import { readRun, type RunProgress, withRun } from "../src/model/run_progress";
import { problemText, readStatus } from "../src/model/status";
import { readHello } from "../src/net/protocol";
import { levelOf, neededFields, panesOf, pinsOf } from "../src/views/bench/axis_fields";

const GARBAGE = [null, undefined, 3, "x", [], {}, true, [null], [3], ["x"], { a: null }, NaN];

describe("what the bench tells of itself", () => {
  it("is read as the door tells it", () => {
    const told = {
      sim_ns: 5e9,
      speed: 2,
      health: { state: "failed", late_ms: 3, problems: [{ kind: "port", about: "m1", what: "no cable", remedy: "plug it in" }, "odd"] },
      devices: [{ device: "m1", failed: null, clients: 1, rx_bytes: 2, tx_bytes: 3, note: null, snapshot: { at_ns: 4e9 }, snapshots: {} }],
    };
    const status = readStatus(told);
    expect(status.health).toEqual({
      state: "failed",
      late_ms: 3,
      problems: [
        { about: "m1", what: "no cable", remedy: "plug it in" },
        { about: "", what: "odd", remedy: "" },
      ],
    });
    expect(status.health?.problems.map(problemText)).toEqual(["m1: no cable; plug it in", "odd"]);
    expect(status.devices[0]).toMatchObject({ device: "m1", clients: 1, note: "", snapshot: { at_ns: 4e9 } });
    expect([status.sim_ns, status.speed, status.elapsed_ns]).toEqual([5e9, 2, undefined]);
  });

  it.each(GARBAGE)("is nothing where it is %j", (garbage) => {
    for (const raw of [
      garbage,
      { sim_ns: garbage, health: garbage, devices: garbage },
      { devices: [garbage], health: { state: garbage, problems: garbage } },
    ]) {
      expect(readStatus(raw).devices).toEqual([]);
    }
    expect(readStatus({ devices: [{ device: "m1", snapshots: garbage, snapshot: garbage, rx_bytes: garbage }] }).devices).toHaveLength(1);
    expect(readFaults([garbage, { number: garbage, kind: "k", target: "t" }]).length).toBeLessThanOrEqual(1);
    expect(readRun(garbage)).toBeNull();
    expect(readRun({ run: "a", axes: { m1: garbage }, steps: garbage })?.axes["m1"]?.at_end).toBeNull();
    expect(
      readHello({
        devices: [{ name: "m1", fields: [garbage], inputs: garbage, verbs: { v: garbage } }],
        ports: [garbage],
        segments: [garbage],
        fault_kinds: [garbage],
      }).devices,
    ).toHaveLength(1);
  });
});

describe("runs", () => {
  const run = (name: string, step: number) => readRun({ run: name, state: "running", step, steps: 9 }) as RunProgress;

  it("stay in their places while they go on", () => {
    const names = [run("a", 1), run("b", 1), run("a", 2), run("b", 2)].reduce<RunProgress[]>(withRun, []);
    expect(names.map(({ run, step }) => [run, step])).toEqual([
      ["b", 2],
      ["a", 2],
    ]);
  });
});

describe("pins", () => {
  const field = (name: string, meaning = "") => ({ name, type: "i32", unit: "", meaning, is_settable: false, is_state: true });
  const device = (inputs: Record<string, string>, fields: ReturnType<typeof field>[]) => ({
    name: "u1",
    profile: "uno",
    is_real: false,
    is_seen: true,
    verbs: {},
    fields,
    inputs,
  });

  it("of a microcontroller are bits of one field", () => {
    const pins = pinsOf(device({ D2: "pin_levels.2", LED: "pin_levels.13", A0: "pin_levels.14" }, [field("pin_levels")]));
    expect(pins.map(({ name, field, bit, isInput }) => [name, field, bit, isInput])).toEqual([
      ["D2", "pin_levels", 2, true],
      ["LED", "pin_levels", 13, true],
      ["A0", "pin_levels", 14, true],
    ]);
    expect([levelOf(0b100, 2), levelOf(0b100, 3), levelOf(5, null)]).toEqual([1, 0, 5]);
    expect(levelOf(NaN, 2)).toBeNaN();
  });

  it("have fields of their own else", () => {
    expect(pinsOf(device({ step: "pin_step", dir: "" }, [field("pin_step"), field("pin_fault")]))).toMatchObject([
      { name: "step", field: "pin_step", bit: null },
      { name: "dir", field: "" },
      { name: "fault", isInput: false },
    ]);
  });
});

describe("bounds", () => {
  it.each([
    [2 ** 53, "2^53"],
    [86400, "86400"],
    [1e18, "1000000000000000000"],
    [0.001, "0.001"],
    [1e12, "1000000000000"],
  ])("%d is %s", (bound, text) => {
    expect(plain(bound)).toBe(text);
  });
});

it("angles of two zeros have two panes, and a set-point has the unit of its mode", () => {
  const field = (name: string, unit: string) => ({ name, unit, type: "f64", meaning: "", is_settable: false, is_state: false });
  const fields = [field("position_deg", "deg"), field("yw", "deg"), field("r", "deg"), field("velocity_rpm", "rpm"), field("mode", "")];
  const servo = { name: "m1", profile: "p", is_real: false, is_seen: true, verbs: {}, fields, inputs: {} };
  const chosen = fields.map((each) => each.name).filter((name) => name !== "mode");
  const names = (...modes: number[]) => panesOf(servo, chosen, modes).map((pane) => [pane.title, pane.unit, pane.fields.map((f) => f.name).join(" ")]);
  expect(names(120)).toEqual([
    ["Shaft's angle", "deg", "position_deg"],
    ["Board's angle and set-point", "deg", "yw r"],
    ["Velocity", "rpm", "velocity_rpm"],
  ]);
  expect(names(118).at(-1)).toEqual(["Velocity", "rpm", "r velocity_rpm"]);
  expect(names(120, 118, 116).map(([, unit, fields]) => [unit, fields])).toEqual([
    ["deg", "position_deg"],
    ["deg", "yw r"],
    ["rpm", "r velocity_rpm"],
    ["", "r"],
  ]);
  expect(panesOf(servo, chosen, [118]).at(-1)!.fields[0]!.unit).toBe("rpm");
  expect(neededFields(servo, ["r", "yw"])).toEqual(["r", "yw", "mode"]);
  expect(neededFields(servo, ["e"])).toEqual(["e", "mode"]);
  expect(neededFields(servo, ["yw"])).toEqual(["yw"]);
  for (const board of ["commanded_deg", "to_be_deg"]) {
    const stepper = { ...servo, fields: [field("position_deg", "deg"), field(board, "deg")] };
    expect(panesOf(stepper, ["position_deg", board]).map((pane) => pane.title)).toEqual(["Shaft's angle", "Board's angle and set-point"]);
  }
  const drive = { ...servo, fields: [field("position_deg", "deg"), field("r", "deg")] };
  expect(panesOf(drive, ["position_deg", "r"], [118]).map((pane) => pane.title)).toEqual(["Position and set-point"]);
});
