import { afterAll, expect, it, vi } from "vitest";
import type { DeviceRow } from "../src/model/door";

vi.stubGlobal("window", { location: { hash: "" }, addEventListener: () => undefined, matchMedia: () => ({ addEventListener: () => undefined }) });
vi.stubGlobal("document", { addEventListener: () => undefined, documentElement: { dataset: {} }, hidden: false });
afterAll(() => vi.unstubAllGlobals());

const { hello } = await import("../src/store");
const { feedOf } = await import("../src/views/bench/axis_feed");
const { PlotModel } = await import("../src/views/bench/plot_model");
const { choose, settingsOf } = await import("../src/views/bench/plot_settings");

const field = (name: string, unit: string) => ({ name, unit, type: "f64", meaning: "", is_settable: false, is_state: false });
const fields = [field("yw", "deg"), field("r", "deg"), field("mode", "")];
const servo = (name: string): DeviceRow => ({ name, profile: "p", is_real: false, is_seen: true, verbs: {}, fields, inputs: {} });

it("has what is chosen of a plot, without what is as usual, and chooses it again", () => {
  const given = {
    signals: ["m1.yw", "m2.yw"],
    window_s: 2,
    right: { "m2.yw": "rpm" },
    xy: { x: "m1.yw", y: "m2.yw", isEqual: true },
    fixed: { deg: [-10, 20] },
    trigger: { level: 12, mode: "normal" },
  };
  const model = new PlotModel(servo("m1"), "a docked one");
  choose(model, given, given.signals);
  expect(settingsOf(model)).toEqual(given);
  choose(model, { signals: ["m1.r"] }, ["m1.r"]);
  expect(settingsOf(model)).toEqual({ signals: ["m1.r"] });
});

it("chooses the usual for what is none of its kind", () => {
  const model = new PlotModel(servo("m1"), "another one");
  const wrong = { window_s: 7, right: [], xy: { x: 1 }, fixed: { deg: [1, 0], rpm: [0, "9"], A: [0, 1] }, trigger: "now" };
  choose(model, wrong, ["m1.yw"]);
  expect(settingsOf(model)).toEqual({ signals: ["m1.yw"], fixed: { A: [0, 1] } });
});

it("draws a field of another axis in the panes of the units that the axis's mode gave it", () => {
  hello.value = { devices: ["m1", "m2"].map(servo) } as never;
  const model = new PlotModel(servo("m1"), "of two");
  model.setSignals(["m1.yw", "m2.r"]);
  const drawn = () => model.panes().map(({ key, fields: shown }) => `${key}: ${shown.map(({ name }) => name).join(" ")}`);
  expect(drawn()).toEqual(["deg: yw m2.r"]);
  feedOf("m2").modes.value = [120, 118];
  expect(drawn()).toEqual(["deg: yw m2.r", "rpm: m2.r"]);
  expect(model.otherFields().map(({ name }) => name)).toEqual(["m2.r"]);
});
