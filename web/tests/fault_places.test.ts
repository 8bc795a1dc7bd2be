import { expect, test } from "vitest";
import { marked } from "../src/model/fault_marks";
import type { FaultKindRow } from "../src/model/door";
import { familyOf, fitting, type PlaceRow, placeTree, readPresets, timingText, withPreset } from "../src/views/faults/fault_places";

const row = (place: string, sort: string, more: Partial<PlaceRow> = {}): PlaceRow => ({ place, sort, of: "", wire: "", kinds: [], ...more });
const kind = (name: string): FaultKindRow => ({ name, title: name, layer: "", target: "", on: "", summary: "", is_once: false, parameters: [] });
const ROWS = [
  row("s1", "device", { kinds: ["shaft_jam", "byte_flip"] }),
  row("s1.network", "port", { of: "s1", wire: "bus0", kinds: ["wire_cut"] }),
  row("bus0.master", "tap", { of: "bus0", wire: "bus0", kinds: ["wire_cut"] }),
  row("bus0", "wire", { wire: "bus0", kinds: ["wire_noise"] }),
];

test("places are boards with their parts, and wires with what is on them", () => {
  const { devices, wires } = placeTree(ROWS);
  expect(devices.map(({ label, parts }) => [label, parts.map((each) => each.label)])).toEqual([["s1", ["network"]]]);
  expect(wires.map(({ label, parts }) => [label, parts.map((each) => each.label)])).toEqual([["bus0", ["s1.network", "master"]]]);
});

test("a place has the kinds that fit it, by family", () => {
  const kinds = ["byte_flip", "wire_noise", "shaft_jam", "encoder_slip"].map(kind);
  expect(fitting(ROWS[0], kinds).map(([family, each]) => [family, each.map(({ name }) => name)])).toEqual([
    ["shaft", ["shaft_jam"]],
    ["cable", ["byte_flip"]],
  ]);
  expect(fitting(undefined, kinds)).toEqual([]);
  expect(["modbus_late", "chip_pin_stuck", "phase_open", "bus_off"].map(familyOf)).toEqual(["packet", "board", "coil", "wire"]);
});

test("presets are read as they can be", () => {
  const preset = { name: "a", kind: "byte_flip", place: "s1", texts: { rate: "0.1" } };
  expect(readPresets([preset, null, { name: 5 }, { ...preset, texts: { rate: 1 } }])).toEqual([preset, { ...preset, texts: {} }]);
  expect(readPresets("x")).toEqual([]);
  expect(withPreset([preset], { ...preset, place: "s2" }).map(({ place }) => place)).toEqual(["s2"]);
  expect([timingText({}), timingText({ for_s: 5, every_s: 30 })]).toEqual(["", "for 5 s, again every 30 s"]);
});

test("a fault that comes again has a mark for each time", () => {
  const fault = { number: 1, kind: "byte_flip", target: "s1", parameters: { for_s: 1, every_s: 3 } };
  const first = marked([], [{ ...fault, begin_s: 10 }], 10);
  const then = marked(first, [{ ...fault, begin_s: 13 }], 11.5);
  expect(then.map(({ begin_s, end_s }) => [begin_s, end_s])).toEqual([
    [10, 11],
    [13, null],
  ]);
  expect(marked(then, [], 12).at(-1)).toMatchObject({ begin_s: 13, end_s: 13 });
});
