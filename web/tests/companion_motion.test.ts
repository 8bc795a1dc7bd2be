import { describe, expect, test } from "vitest";
import { calibrationLine, factorText, judged } from "../src/views/companion/calibration";
import { isRunning, withName, withOperation, type CommandTime } from "../src/views/companion/command_times";
import { afterBegin, afterEnd, afterLine, afterListing, runningText, STANDING, type Motion } from "../src/views/companion/running_row";
import { recalled, withIncoming, withSent } from "../src/views/companion/text_log";

/** Rows that run, when these lines are typed and the commands begin and end one after the other. */
function runs(lines: readonly string[], count: number, next = 1): unknown[] {
  let motion: Motion = lines.reduce(afterLine, { ...STANDING, next });
  return Array.from({ length: count }, () => {
    motion = afterBegin(afterEnd(motion));
    return motion.running;
  });
}

describe("what runs", () => {
  test("queued commands run at the places where the next goes", () => {
    expect(runs(["m200", "m-300v20"], 3, 30)).toEqual([30, 1, "unknown"]);
  });

  test("a loop goes from start to finish, around the end", () => {
    expect(runs(["ls29", "lf1"], 5)).toEqual([29, 30, 1, 29, 30]);
    expect(runs(["lf4", "ls3"], 3)).toEqual([3, 4, 3]);
    expect(runs(["la"], 2)).toEqual([1, 2]);
    expect(runs(["ls3", "lf3"], 1)).toEqual(["unknown"]);
    expect(runs(["ls0", "lf31"], 1)).toEqual(["unknown"]);
    expect(runs(["ls3", "lf4", "l"], 1)).toEqual(["unknown"]);
  });

  test("one-shots and recalled rows come first, and the loop goes on", () => {
    expect(runs(["ls3", "lf4", "x9"], 3)).toEqual([9, 3, 4]);
    expect(runs(["ls3", "lf4", "xm100v150"], 2)).toEqual(["one-shot", 3]);
    expect(runs(["m"], 1)).toEqual(["continuous"]);
    expect(runs(["xm-v20"], 1)).toEqual(["continuous"]);
    expect(runs(["x31"], 1)).toEqual(["unknown"]);
    expect(runs(["xl3"], 1)).toEqual(["unknown"]);
  });

  test("a stop ends loops and what waits", () => {
    expect(runs(["ls3", "lf4", "S"], 1)).toEqual(["unknown"]);
    expect(runs(["m200", "$O1"], 1)).toEqual(["unknown"]);
  });

  test("a listing tells what was not known", () => {
    const moving = afterBegin(STANDING);
    expect(afterListing(moving, 7, true).running).toBe(7);
    expect(afterListing(STANDING, 7, false).next).toBe(7);
    const shot = afterBegin(afterLine(STANDING, "xm100"));
    expect(afterListing(shot, 7, true).running).toBe("one-shot");
    const looping = ["ls3", "lf9"].reduce(afterLine, STANDING);
    expect(afterBegin(afterListing(afterBegin(looping), 6, true)).running).toBe(7);
    expect(["", "row 3", "one-shot"]).toEqual([undefined, 3, "one-shot" as const].map(runningText));
  });
});

describe("times of commands", () => {
  test("are from DC1 to DC2", () => {
    let times: readonly CommandTime[] = withOperation([], { kind: "ends", at_ms: 5 }, "");
    expect(times).toEqual([]);
    times = withName(withOperation(times, { kind: "begins", at_ms: 100 }, ""), "row 3");
    expect(isRunning(times)).toBe(true);
    times = withOperation(times, { kind: "ends", at_ms: 850 }, "");
    expect(times).toEqual([{ number: 1, begun_ms: 100, duration_ms: 750, what: "row 3" }]);
    expect([isRunning(times), withName(times, "x")]).toEqual([false, times]);
  });
});

describe("calibration", () => {
  const board = {
    steps_per_rev: 200,
    microstep_exponent: 1,
    interrupt_overhead_us: 8,
    clock_correction_us: 0,
    slow_rpm: 10,
    is_network_swapped: false,
  };

  test("runs for a minute without a ramp, and waits for its echo", () => {
    expect(calibrationLine(60, board)).toEqual({ line: "xm12000v60a999d999u0ft200000" });
    expect(calibrationLine(0, board)).toEqual({ refused: "0 RPM is no speed at 200 steps a turn" });
    expect(calibrationLine(10 ** 9, board)).toHaveProperty("refused");
  });

  test("finds the factor, and what corrects it", () => {
    expect(judged(60, board, 60_000)).toMatchObject({ factor: 1, remedy: "", correction_us: 0 });
    expect(factorText(judged(60, board, 60_000))).toBe("1.000000 (+0 ppm)");
    expect(judged(160, board, 60_320)).toMatchObject({ correction_us: -5, remedy: "$CH13" });
    expect(judged(160, board, 59_680)).toMatchObject({ correction_us: 5, remedy: "$CI5" });
    expect(factorText(judged(160, board, 59_680))).toBe("0.994667 (-5333 ppm)");
  });
});

describe("histories", () => {
  test("what a board says is shown as what it is", () => {
    expect(withIncoming("SAC>", "q\r\n\x1b[2J\x07<b>\xff\r\n")).toBe("SAC>q\n\\x1b[2J\\x07<b>\xff\n");
    const long = withIncoming("", "a line\r\n".repeat(10_000));
    expect(long.length).toBeLessThanOrEqual(30_000);
    expect(long.startsWith("a line\n")).toBe(true);
  });

  test("what was typed can be had again", () => {
    const sent = ["q", "m1", "q"].reduce((all, line, index) => withSent(all, line, index), withSent([], "z", 9));
    expect(recalled(sent)).toEqual(["q", "m1", "z"]);
    expect(sent.at(-1)!.number).toBe(4);
  });
});
