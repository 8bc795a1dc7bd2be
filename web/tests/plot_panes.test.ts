import { expect, it } from "vitest";
import type { DeviceRow } from "../src/model/door";
import { fieldAt, fieldsBeside, neededFields, panesOf, usualFields } from "../src/views/bench/axis_fields";

const field = (name: string, unit: string) => ({ name, unit, type: "f64", meaning: "", is_settable: false, is_state: false });
const fields = [field("position_deg", "deg"), field("velocity_rpm", "rpm"), field("current_a_A", "A"), field("current_b_A", "A")];
const drive: DeviceRow = { name: "m1", profile: "p", is_real: false, is_seen: true, verbs: {}, fields, inputs: {} };
const all = fields.map(({ name }) => name);

/** Panes as "key: left fields | right fields". */
function drawn(right: Record<string, string>, chosen = all, others = fieldsBeside({ ...drive, name: "m2" }).slice(0, 0)): string[] {
  return panesOf(drive, chosen, [], others, right).map((pane) => {
    const names = (isRight: boolean) =>
      pane.fields
        .filter((each) => each.isRight === isRight)
        .map(({ name }) => name)
        .join(" ");
    return `${pane.key}: ${names(false)} | ${names(true)}`;
  });
}

it("draws a field at the right axis of another pane", () => {
  expect(drawn({})).toEqual(["deg: position_deg | ", "rpm: velocity_rpm | ", "A: current_a_A current_b_A | "]);
  expect(drawn({ velocity_rpm: "deg" })).toEqual(["deg: position_deg | velocity_rpm", "A: current_a_A current_b_A | "]);
  expect(panesOf(drive, all, [], [], { velocity_rpm: "deg" })[0]).toMatchObject({ unit: "deg", rightUnit: "rpm" });
});

it("leaves a field where its pane has no left field, or a right one of another unit", () => {
  expect(drawn({ velocity_rpm: "deg", position_deg: "rpm" })).toEqual(drawn({}));
  expect(drawn({ velocity_rpm: "Nm" })).toEqual(drawn({}));
  expect(drawn({ velocity_rpm: "deg", current_a_A: "deg" })).toEqual(["deg: position_deg | velocity_rpm", "A: current_a_A current_b_A | "]);
  expect(drawn({ current_a_A: "deg", current_b_A: "deg" })).toEqual(["deg: position_deg | current_a_A current_b_A", "rpm: velocity_rpm | "]);
});

it("has fields of other devices in the panes of their units, or at a right axis", () => {
  const others = fieldsBeside({ ...drive, name: "w1.arm" }).filter(({ unit }) => unit === "rpm");
  expect(drawn({}, ["position_deg"], others)).toEqual(["deg: position_deg | ", "rpm: w1.arm.velocity_rpm | "]);
  expect(drawn({ "w1.arm.velocity_rpm": "deg" }, ["position_deg"], others)).toEqual(["deg: position_deg | w1.arm.velocity_rpm"]);
});

it("finds a field by its address, and what to watch of an axis without one", () => {
  const devices = new Map([["w1.arm", { ...drive, name: "w1.arm" }]]);
  expect(fieldAt(devices, "w1.arm.velocity_rpm")?.field.unit).toBe("rpm");
  for (const address of ["velocity_rpm", "w1.velocity_rpm", "w1.arm.nothing", ""]) expect(fieldAt(devices, address)).toBeNull();
  expect(neededFields(drive, [])).toEqual(["position_deg"]);
});

it("draws a board's own fields where it has no motor and no pins", () => {
  const own = ["at_ns", "temperature_degC", "heater"].map((name) => ({ ...field(name, ""), is_state: true }));
  const board = { ...drive, fields: own };
  expect(usualFields(board)).toEqual(["temperature_degC", "heater"]);
  expect(usualFields({ ...board, inputs: { D2: "" } })).toEqual([]);
  expect(usualFields({ ...drive, fields: [...fields, ...own] })).toEqual(all);
});
