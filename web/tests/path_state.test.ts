import { signal } from "@preact/signals";
import { afterAll, beforeEach, describe, expect, it, vi } from "vitest";
import { readRun, type RunProgress } from "../src/model/run_progress";
import type { Status } from "../src/model/status";

const bench = vi.hoisted(() => ({ answers: {} as Record<string, unknown> }));

vi.mock("../src/store", () => ({
  devices: signal(new Map()),
  link: { ask: (operation: string) => Promise.resolve(bench.answers[operation]), state: signal("open") },
  may: () => true,
  runs: signal<RunProgress[]>([]),
  status: signal<Status>({ devices: [], wires: [], doors: [] }),
  takeProgress: () => undefined,
}));
const store = new Map<string, string>();
vi.stubGlobal("localStorage", {
  getItem: (key: string) => store.get(key) ?? null,
  setItem: (key: string, text: string) => void store.set(key, text),
  removeItem: (key: string) => void store.delete(key),
});
afterAll(() => vi.unstubAllGlobals());

const { link, runs, status } = await import("../src/store");
const { flush, keptFor, unsaved } = await import("../src/kept");
const state = await import("../src/views/path/path_state");
const { drafts, drawing, done, focused, follow, goOn, isPlanned, mayStart, nextPart, offered, otherRun, plan, run, start, takeTexts } = state;

const DRAWING = {
  problems: [],
  remarks: [],
  digest: "D1",
  machine: "mill",
  figures: { lines: 5, duration_s: 3, feed_mm: 20, rapid_mm: 10, range: { x: [0, 10] } },
  axes: [{ letter: "x", axis: "m1", unit: "mm", deg_per_unit: 9, zero_deg: 0 }],
  path: { places: [0, 10, 0], count: 3, rapids: [], lines: [[1, 3]], is_whole: true },
  runs: [
    { text: "{}", digest: "d1", duration_s: 1, timeline: [[0, 2]], pause_line: 2 },
    { text: "{}", digest: "d2", duration_s: 2, timeline: [[0, 3]], pause_line: null },
  ],
};
const THEIRS = { ...DRAWING, digest: "D2", text: "theirs", machine_text: "m", file: "plot.ngc", runs: [{ ...DRAWING.runs[1], digest: "t1" }] };

function progress(name: string, digest: string, state: string): RunProgress {
  return readRun({ run: name, digest, state, gone_ns: 5e8, axes: { m1: {} } })!;
}

/** The bench has a drawing now, and the page has heard of it. */
async function drawn(theirs: { digest: string }): Promise<void> {
  bench.answers = { ...bench.answers, drawing: theirs };
  status.value = { ...status.peek(), drawing: theirs.digest };
  await follow();
}

let benches = 0;
beforeEach(async () => {
  runs.value = [];
  status.value = { devices: [], wires: [], doors: [], drawing: "" };
  drawing.value = null;
  focused.value = null;
  await follow();
  keptFor.value = `bench${benches++}`;
  bench.answers = { drawing: DRAWING };
});

describe("a drawing's run", () => {
  it("is that of its own digest alone, whatever it is called", async () => {
    await plan();
    runs.value = [progress("mill_1", "x9", "running")];
    expect([run.value, done.value, otherRun.value?.run, mayStart.value]).toEqual([null, null, "mill_1", false]);
    runs.value = [progress("mill_1", "x9", "done"), progress("mill_1-2", "d1", "running")];
    expect([run.value?.run, otherRun.value]).toEqual(["mill_1-2", null]);
    runs.value = [progress("mill_1-2", "d1", "done")];
    expect([run.value?.run, nextPart.value]).toEqual(["mill_1-2", 1]);
  });

  it("is the one that moves, else the last one", async () => {
    await plan();
    runs.value = [progress("mill-2", "d2", "done"), progress("mill", "d1", "done")];
    expect(run.value?.run).toBe("mill-2");
    runs.value = [progress("mill-2", "d2", "done"), progress("mill", "d1", "running")];
    expect(run.value?.run).toBe("mill");
  });

  it("of a page without digests is none of its own", async () => {
    await plan();
    runs.value = [readRun({ run: "mill", state: "running" })!];
    expect(run.value).toBeNull();
  });
});

describe("the drawing of somebody else", () => {
  it("comes with its texts where nobody has written here", async () => {
    await drawn(THEIRS);
    expect([drafts.program.value.text, drafts.machine.value.text, isPlanned.value, offered.value]).toEqual(["theirs", "m", true, null]);
    await drawn({ ...THEIRS, digest: "D3" });
    expect(drawing.value?.digest).toBe("D3");
  });

  it("is shown, and leaves what was typed until its texts are taken", async () => {
    drafts.program.type("mine");
    await drawn(THEIRS);
    expect([drafts.program.value.text, drawing.value?.digest, isPlanned.value, offered.value]).toEqual(["mine", "D2", false, "plot.ngc"]);
    drafts.program.type("mine, too");
    expect(drafts.program.value.text).toBe("mine, too");
    takeTexts();
    expect([drafts.program.value.text, isPlanned.value, offered.value]).toEqual(["theirs", true, null]);
  });

  it("leaves the texts while one of them has the focus", async () => {
    focused.value = "program";
    await drawn(THEIRS);
    expect(drafts.program.value.text).not.toBe("theirs");
    expect(offered.value).toBe("plot.ngc");
  });

  it("waits for the end of the one that runs here", async () => {
    await plan();
    runs.value = [progress("mill", "d1", "running")];
    await drawn(THEIRS);
    expect([drawing.value?.digest, run.value?.run]).toEqual(["D1", "mill"]);
    runs.value = [progress("mill", "d1", "done")];
    await follow();
    expect([drawing.value?.digest, run.value]).toEqual(["D2", null]);
  });

  it("does not replace one that a viewer checks", async () => {
    await drawn(THEIRS);
    bench.answers = { drawing: DRAWING };
    await plan();
    await follow();
    expect(drawing.value?.digest).toBe("D1");
  });
});

describe("a drawing of several runs", () => {
  const two = (pause_line: number | null) => ({ ...DRAWING, runs: [{ ...DRAWING.runs[0], pause_line }, DRAWING.runs[1]] });

  it.each([
    [null, ["d1", "d2"]],
    [2, ["d1"]],
  ])("goes on by itself unless the program pauses, at %s", async (pause_line, started) => {
    bench.answers = { drawing: two(pause_line), run: { run: "mill", state: "queued", digest: "d1" } };
    const asked = vi.spyOn(link, "ask");
    await start();
    runs.value = [progress("mill", "d1", "done")];
    await goOn();
    await goOn();
    expect(asked.mock.calls.filter(([operation]) => operation === "run")).toHaveLength(started.length);
    asked.mockRestore();
  });

  it("is not gone on with where it was not started", async () => {
    bench.answers = { drawing: { ...two(null), digest: "D9" } };
    await plan();
    runs.value = [progress("mill", "d1", "done")];
    const asked = vi.spyOn(link, "ask");
    await goOn();
    expect(asked).not.toHaveBeenCalled();
    asked.mockRestore();
  });
});

describe("what is typed", () => {
  it("is kept for its bench, with whether it is saved", async () => {
    drafts.program.type("G0 X1");
    flush();
    const [key, text] = [...store].find(([, each]) => each.includes('"G0 X1"'))!;
    expect(key).toBe(`hil.kept.1/${keptFor.peek()}/path.program`);
    expect(JSON.parse(text)).toEqual({ text: "G0 X1", file: "program.ngc", isOwn: true, isSaved: false });
    expect(unsaved.value).toEqual(["the program"]);
  });

  it("is saved when it was started, and not what was typed meanwhile", async () => {
    drafts.program.type("G0 X1");
    bench.answers = { drawing: DRAWING, run: { run: "mill", state: "queued", digest: "d1" } };
    await start();
    expect(unsaved.value).toEqual([]);
    drafts.program.type("G0 X2");
    const starting = start();
    drafts.program.type("G0 X3");
    await starting;
    expect(unsaved.value).toEqual(["the program"]);
  });

  it.each(["{}", '{"text":5}', "[]", "null", "7"])("is the example where %s was kept", (text) => {
    store.set("hil.kept.1/damaged/path.program", text);
    keptFor.value = "damaged";
    expect(drafts.program.value.text).toContain("G21");
    store.clear();
    keptFor.value = "demo";
  });
});
