import { describe, expect, it } from "vitest";
import { type AxisCard, cardOf, errorOf, errorShare, inOrder, modeOf, movesIn, setPointOf } from "../src/model/axis_card";
import { readStatus } from "../src/model/status";

const SERVO = { loop_on: 1, mode: 120, r: 90, e: 0.5, position_deg: 89.5, velocity_rpm: 0 };
const SAC = { motion_state: 2, commanded_deg: 10, lag_steps: -0.25, velocity_rpm: 60 };
const BESIDE = { faults: [], marks: [], problems: [], bytes_per_s: 0, isOpen: true };

function row(device: string, more: Record<string, unknown> = {}) {
  return readStatus({ devices: [{ device, failed: null, clients: 0, snapshots: {}, snapshot: SERVO, ...more }] }).devices[0];
}

describe("a card of an axis", () => {
  it.each([
    [SERVO, "x", { value: 90, unit: "deg" }, { value: 0.5, unit: "deg" }, false],
    [{ ...SERVO, mode: 118, r: 30, velocity_rpm: 30 }, "v", { value: 30, unit: "rpm" }, { value: 0.5, unit: "rpm" }, true],
    [{ ...SERVO, mode: 116 }, "t", { value: 90, unit: "counts" }, null, false],
    [{ ...SERVO, loop_on: 0 }, "off", null, null, false],
    [SAC, "cruise", { value: 10, unit: "deg" }, { value: -0.25, unit: "steps" }, true],
    [{ is_enabled: 1, to_be_deg: 5, position_deg: 4 }, "on", { value: 5, unit: "deg" }, null, false],
    [{ outputs_on: 1, microsteps: 8 }, "1/8 step", null, null, false],
    [{}, "", null, null, false],
    [null, "", null, null, false],
  ])("says mode, set-point and error of %j", (shot, mode, setPoint, error, moves) => {
    expect([modeOf(shot), setPointOf(shot), errorOf(shot), movesIn(shot)]).toEqual([mode, setPoint, error, moves]);
  });

  it("says what is wrong, the worst first", () => {
    const fault = { number: 1, kind: "shaft_jam", target: "m1", parameters: {}, begin_s: 3 };
    const marks = [{ number: 1, kind: "shaft_jam", target: "m1", begin_s: 3, end_s: null }];
    const m1 = { name: "m1", profile: "mechaduino" };
    expect(cardOf(m1, row("m1"), BESIDE)).toMatchObject({ state: "ok", lastFault: "" });
    expect(cardOf(m1, row("m1"), { ...BESIDE, faults: [fault], marks })).toMatchObject({
      state: "fault",
      stateText: "shaft jam",
      lastFault: "shaft jam, since 3.0 s",
    });
    const problems = [{ about: "m1", what: "its cable is out", remedy: "put it in" }];
    expect(cardOf(m1, row("m1"), { ...BESIDE, problems })).toMatchObject({ state: "failed", why: "its cable is out; put it in" });
    expect(cardOf(m1, row("m1", { failed: "brown-out" }), BESIDE)).toMatchObject({ state: "failed", why: "brown-out" });
    expect(cardOf(m1, undefined, { ...BESIDE, isOpen: false })).toMatchObject({ state: "unknown", stateText: "unknown" });
    expect(cardOf({ name: "m10", profile: "" }, row("m10"), { ...BESIDE, faults: [fault], problems }).state).toBe("ok");
  });

  it("comes with trouble first, and is found by its words", () => {
    const card = (name: string, state: AxisCard["state"]) => ({ ...cardOf({ name, profile: "sac" }, row(name), BESIDE), state });
    const cards = [card("a", "ok"), card("b", "fault"), card("c", "ok"), card("d", "failed")];
    expect(inOrder(cards, "").map(({ name }) => name)).toEqual(["d", "b", "a", "c"]);
    expect(inOrder(cards, " C ").map(({ name }) => name)).toContain("c");
    expect(inOrder(cards, "nothing")).toEqual([]);
  });

  it("has a bar on which small errors show and large ones end", () => {
    expect([errorShare(0), errorShare(1e9)]).toEqual([0, 1]);
    expect(errorShare(0.1)).toBeGreaterThan(0.05);
    expect(errorShare(-5)).toBe(errorShare(5));
  });
});

describe("wires and doors of the status", () => {
  it("are read with their nodes", () => {
    const bus = {
      bus: "can0",
      load_percent: 3,
      frames: 7,
      errors: { ack: 2 },
      nodes: { "m1.canopen": { state: "bus-off", transmit_errors: 256, receive_errors: 1 }, x: { state: "error-active" } },
      drives: { "m1.canopen": { id: 5, state: "stopped" } },
      notes: [],
    };
    const segment = {
      segment: "bus0",
      load: 0.25,
      packets: 3,
      collisions: 1,
      stations: { "s1.network": { bursts: 2, collisions: 1 } },
      nodes: {},
      notes: ["n"],
    };
    const bridges = { web: { root: "http://x/", links: 2, commands: 9, rejected: 1, dropped: 0, risk: "" } };
    const { wires, doors } = readStatus({ segments: [segment, null], buses: [bus], bridges });
    expect(wires.map(({ name, load_percent, errors }) => [name, load_percent, errors])).toEqual([
      ["bus0", 25, 0],
      ["can0", 3, 2],
    ]);
    expect(wires[0]!.nodes).toEqual([{ name: "s1.network", state: "", isBad: true, counts: "2 bursts" }]);
    expect(wires[1]!.nodes[0]).toEqual({ name: "m1.canopen", state: "bus-off, stopped", isBad: true, counts: "TEC 256 REC 1" });
    expect(wires[1]!.nodes[1]).toMatchObject({ state: "error-active", isBad: false });
    expect(doors).toEqual([{ name: "web", address: "http://x/", links: 2, commands: 9, rejected: 1, dropped: 0, risk: "", isJoined: false }]);
  });
});
