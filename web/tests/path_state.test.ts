import { signal } from "@preact/signals";
import { afterAll, beforeEach, describe, expect, it, vi } from "vitest";
import { readRun, type RunProgress } from "../src/model/run_progress";

const bench = vi.hoisted(() => ({ answers: {} as Record<string, unknown> }));

vi.mock("../src/store", () => ({
  link: { ask: (operation: string) => Promise.resolve(bench.answers[operation]), state: signal("open") },
  may: () => true,
  runs: signal<RunProgress[]>([]),
  takeProgress: () => undefined,
}));
vi.stubGlobal("localStorage", { getItem: () => null, setItem: () => undefined, removeItem: () => undefined });
afterAll(() => vi.unstubAllGlobals());

const { runs } = await import("../src/store");
const { done, drawing, focused, follow, isPlanned, nextPart, plan, run, setText, texts } = await import("../src/views/path/path_state");

const DRAWING = {
  problems: [],
  remarks: [],
  machine: "mill",
  figures: { lines: 5, duration_s: 3, feed_mm: 20, rapid_mm: 10, range: { x: [0, 10] } },
  axes: [{ letter: "x", axis: "m1", unit: "mm", deg_per_unit: 9, zero_deg: 0 }],
  path: { places: [0, 10, 0], count: 3, rapids: [], lines: [[1, 3]], is_whole: true },
  runs: [
    { text: "{}", duration_s: 1, timeline: [[0, 2]], pause_line: 2 },
    { text: "{}", duration_s: 2, timeline: [[0, 3]], pause_line: null },
  ],
};

function progress(name: string, state: string, started_at_ns: number): RunProgress {
  return readRun({ run: name, state, started_at_ns, gone_ns: 5e8 })!;
}

beforeEach(() => {
  drawing.value = null;
  focused.value = null;
  runs.value = [];
  setText("program", "mine");
  setText("machine", "");
  bench.answers = { drawing: DRAWING };
});

describe("a drawing's run", () => {
  it("is not the one that had ended before the drawing was planned", async () => {
    runs.value = [progress("mill_1", "done", 7)];
    await plan();
    expect([run.value, done.value, nextPart.value]).toEqual([null, null, null]);
    runs.value = [progress("mill_1-2", "running", 9), ...runs.value];
    expect(run.value?.run).toBe("mill_1-2");
    runs.value = [progress("mill_1-2", "done", 9), progress("mill_1", "done", 7)];
    expect([run.value?.run, nextPart.value]).toEqual(["mill_1-2", 1]);
  });

  it("goes on while the drawing is planned again", async () => {
    runs.value = [progress("mill_1", "running", 7)];
    await plan();
    runs.value = [progress("mill_1", "done", 7)];
    expect(run.value?.state).toBe("done");
  });

  it("may have the name of a former one, after a start of the bench", async () => {
    runs.value = [progress("mill_1", "done", 7)];
    await plan();
    runs.value = [progress("mill_1", "done", 3)];
    expect(run.value?.started_at_ns).toBe(3);
  });

  it("is the last one where the page comes later than the drawing", async () => {
    runs.value = [progress("mill_1", "done", 7)];
    bench.answers = { drawing: { ...DRAWING, text: "theirs", machine_text: "m" } };
    await follow();
    expect(run.value?.run).toBe("mill_1");
  });
});

describe("the drawing of somebody else", () => {
  it("comes with its texts", async () => {
    bench.answers = { drawing: { ...DRAWING, text: "theirs", machine_text: "m" } };
    await follow();
    expect([texts.program.value, texts.machine.value, isPlanned.value]).toEqual(["theirs", "m", true]);
  });

  it("leaves the texts while one of them has the focus", async () => {
    bench.answers = { drawing: { ...DRAWING, text: "theirs", machine_text: "m" } };
    focused.value = "program";
    await follow();
    expect([texts.program.value, texts.machine.value, isPlanned.value]).toEqual(["mine", "", false]);
    expect(drawing.value?.machine).toBe("mill");
  });
});
