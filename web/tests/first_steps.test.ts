import { describe, expect, it } from "vitest";
import type { DeviceRow, FaultKindRow, ParameterRow, VerbRow } from "../src/model/door";
import { stepBefore, firstSteps } from "../src/model/first_steps";
import { readStatus } from "../src/model/status";

const angle = { name: "angle_deg", unit: "deg" } as ParameterRow;
const verb = (parameters: ParameterRow[] = []): VerbRow => ({ summary: "", role: "operator", parameters });
const JAM = { name: "shaft_jam" } as FaultKindRow;

function device(name: string, verbs: Record<string, VerbRow>, more: Partial<DeviceRow> = {}): DeviceRow {
  const fields = [{ name: "position_deg", type: "f64", unit: "deg", meaning: "", is_settable: false, is_state: true }];
  return { name, profile: "p", is_real: false, is_seen: true, verbs, fields, inputs: {}, ...more };
}

const row = (name: string, more: Record<string, unknown> = {}) => ({
  device: name,
  failed: null,
  greeting: "",
  clients: 0,
  snapshot: { position_deg: 0 },
  ...more,
});
const all = () => true;

describe("things to try", () => {
  const m1 = device("m1", { enable: verb(), move_rel: verb([angle]) });
  const s1 = device("s1", { move_rel: verb([angle]) });
  const bench = { bench: "b", devices: [m1, s1], ports: ["m1", "s1"], fault_kinds: [JAM] };
  const status = readStatus({ devices: [row("m1", { greeting: "p" }), row("s1", { greeting: "\r" })] });

  it("begin with a calibration where the board is new", () => {
    const [turn] = firstSteps(bench, status, all);
    expect(stepBefore(turn!, "the look-up table is empty; calibrate it first")!.commands).toEqual(["hil axis m1 disable", "hil axis m1 calibrate"]);
    expect(stepBefore(turn!, "it starts, and takes commands 4 s after power-up; wait until then")).toBeNull();
  });

  it("are turning, typing and breaking, each with its command", () => {
    const steps = firstSteps(bench, status, all);
    expect(steps.map(({ kind, commands }) => [kind, ...commands])).toEqual([
      ["turn", "hil axis m1 enable", "hil axis m1 move-rel 90"],
      ["type", "hil type s1 '' --enter"],
      ["break", "hil fault inject shaft_jam m1 for_s=3"],
    ]);
    expect(steps[0]!.requests.map(({ given }) => given)).toEqual([
      { name: "enable", parameters: {} },
      { name: "move_rel", parameters: { angle_deg: 90 } },
    ]);
  });

  it("are of what the bench has, and nothing that would be refused", () => {
    expect(firstSteps(bench, status, () => false)).toEqual([]);
    expect(firstSteps(bench, status, (role) => role !== "admin").map(({ kind }) => kind)).toEqual(["turn", "type"]);
    expect(firstSteps({ ...bench, devices: [], ports: [] }, readStatus({}), all)).toEqual([]);
    expect(firstSteps({ ...bench, fault_kinds: [] }, status, all).map(({ kind }) => kind)).toEqual(["turn", "type"]);
    const failed = readStatus({ devices: [row("m1", { failed: "hung" }), row("s1", { greeting: "\r", clients: 1 })] });
    expect(firstSteps(bench, failed, all).map(({ commands }) => commands)).toEqual([["hil axis s1 move-rel 90"], ["hil fault inject shaft_jam s1 for_s=3"]]);
    const real = { ...bench, devices: [device("r1", m1.verbs, { is_real: true })], ports: [] };
    expect(firstSteps(real, readStatus({ devices: [row("r1")] }), all)).toEqual([]);
  });
});
