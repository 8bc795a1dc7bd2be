import { describe, expect, it } from "vitest";
import { countsOf, type EventRow, filtered, marksBefore, marksWith, NO_EVENTS, readEvent, withRows, wordsOf } from "../src/model/bench_events";

const RAW = { number: 3, revision: 4, kind: "verbs", at_ns: 2e9, to_ns: 3e9, of: "m1", who: "ann", text: "enable", count: 2 };
const row = (number: number, more: Partial<EventRow> = {}): EventRow => ({ ...readEvent({ ...RAW, number }, "a")!, ...more });
const said = (text: string, at_s = 2): EventRow => row(0, { key: `page ${text}`, kind: "refusals", who: "this page", of: "", text, at_s });

describe("events of the bench", () => {
  it("are read as the door tells them", () => {
    expect(readEvent(RAW, "a")).toEqual({ key: "a 3", kind: "verbs", at_s: 2, to_s: 3, of: "m1", who: "ann", text: "enable", count: 2, instance: "a" });
    for (const garbage of [null, 3, {}, { ...RAW, number: "x" }, { ...RAW, kind: "others" }, { ...RAW, text: 1 }]) expect(readEvent(garbage, "a")).toBeNull();
  });

  it("have the log's warnings among them", () => {
    const warning = readEvent({ ...RAW, kind: "log", text: "WARNING the disk is full" }, "a")!;
    expect(filtered([warning], [], "disk")).toEqual([warning]);
    expect(countsOf([warning]).log).toBe(1);
  });

  it("take the places of those of before, and stay in the order of time", () => {
    const first = withRows(NO_EVENTS, [row(1, { at_s: 5 }), row(2, { at_s: 4 })]);
    const then = withRows(first, [row(1, { at_s: 5, count: 9 })]);
    expect(then.rows.map(({ key, count }) => [key, count])).toEqual([
      ["a 2", 2],
      ["a 1", 9],
    ]);
    expect(withRows(then, [row(1, { key: "b 1", instance: "b", at_s: 0 })]).rows.at(-1)!.instance).toBe("b");
  });

  it("have a limit, and say how many were left out", () => {
    const { rows, leftOut } = withRows(
      NO_EVENTS,
      Array.from({ length: 30 }, (_, number) => row(number, { at_s: number })),
      20,
    );
    expect([rows.length, leftOut, rows[0]!.at_s]).toEqual([20, 10, 10]);
  });

  it("have a refusal once, whoever tells it first", () => {
    const bench = row(7, { kind: "refusals", text: "enable: the loop is on already; disable it" });
    const page = said("the loop is on already; disable it");
    for (const order of [
      [bench, page],
      [page, bench],
    ]) {
      expect(order.reduce((before, each) => withRows(before, [each]), NO_EVENTS).rows).toEqual([bench]);
    }
    expect(withRows(withRows(NO_EVENTS, [bench]), [said("there is no connection")]).rows).toHaveLength(2);
  });

  it("are found by kind and by words, the newest first", () => {
    const rows = [row(1), row(2, { kind: "faults", text: "shaft_jam", of: "m2" }), row(3, { text: "stop", who: "control socket" })];
    expect(filtered(rows, [], "").map(({ key }) => key)).toEqual(["a 3", "a 2", "a 1"]);
    expect(filtered(rows, ["faults"], "").map(({ key }) => key)).toEqual(["a 3", "a 1"]);
    expect(filtered(rows, [], "socket STOP").map(({ key }) => key)).toEqual(["a 3"]);
    expect(countsOf(rows)).toMatchObject({ verbs: 2, faults: 1, runs: 0 });
  });

  it("are marks of the time line where a recording has none", () => {
    const recorded = [{ lane: "verbs", from_s: 1, to_s: 1, of: "m1", text: "m1 enable" }];
    const rows = [row(1), row(2, { kind: "clients", of: "s1", who: "s1", text: "one came" }), row(3, { kind: "clients", instance: "b" })];
    expect(marksWith(recorded, rows, "a").map(({ lane, text }) => [lane, text])).toEqual([
      ["verbs", "m1 enable"],
      ["clients", "s1: one came"],
    ]);
    expect(wordsOf(row(1))).toBe("m1: enable (ann)");
  });

  it("are faults of before, for a page that came later", () => {
    const rows = [row(1), row(2, { kind: "faults", of: "m2", text: "shaft_jam for_s 20", at_s: 14 }), row(3, { kind: "faults", of: "", text: "1 ended" })];
    expect(marksBefore(rows)).toEqual([{ number: 0, kind: "shaft_jam", target: "m2", begin_s: 14, end_s: 14 }]);
  });
});
