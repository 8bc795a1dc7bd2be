import { describe, expect, it } from "vitest";
import { Acquisition, EdgeFinder, readTrigger, stateText, USUAL_TRIGGER } from "../src/model/trigger";

/** Places of a list of values at which an edge ends. */
function edges(finder: EdgeFinder, values: number[]): number[] {
  return values.flatMap((value, at) => (finder.take(value) ? [at] : []));
}

describe("EdgeFinder", () => {
  it("finds rising and falling edges, or either", () => {
    const values = [0, 2, 0, 2, 2, 0];
    expect(edges(new EdgeFinder("rising", 1, 0), values)).toEqual([1, 3]);
    expect(edges(new EdgeFinder("falling", 1, 0), values)).toEqual([2, 5]);
    expect(edges(new EdgeFinder("either", 1, 0), values)).toEqual([1, 2, 3, 5]);
  });

  it("does not fire where the signal is above from the start, nor twice while it stays there", () => {
    expect(edges(new EdgeFinder("rising", 1, 0), [5, 6, 5, 1])).toEqual([]);
    expect(edges(new EdgeFinder("rising", 1, 0), [0, 1, 1, 1])).toEqual([1]);
  });

  it("wants the signal back by the hysteresis: noise about the level fires once", () => {
    const noise = [0, 1.1, 0.95, 1.05, 0.9, 1.2, 0.4, 1.3];
    expect(edges(new EdgeFinder("rising", 1, 0.5), noise)).toEqual([1, 7]);
    expect(edges(new EdgeFinder("falling", 1, 0.5), [2, 0.9, 1.1, 0.9, 1.6, 1])).toEqual([1, 5]);
  });

  it("finds a pulse between two samples by its extremes, and passes over what is missing", () => {
    expect(edges(new EdgeFinder("rising", 1, 0), [0, 0, 0, 3, 0, 0])).toEqual([3]);
    expect(edges(new EdgeFinder("rising", 1, 0), [0, NaN, 2])).toEqual([2]);
  });
});

describe("Acquisition", () => {
  it("collects what is before, waits, collects what is behind, and holds once", () => {
    const made = new Acquisition("once", 10, 20, 100);
    made.fire(101);
    expect([made.state, made.advance(101.9)]).toEqual(["armed", null]);
    made.advance(102);
    expect(made.state).toBe("waiting");
    made.fire(105);
    made.fire(106);
    expect([made.state, made.at_s, made.advance(112.9)]).toEqual(["triggered", 105, null]);
    expect(made.advance(113)).toEqual([103, 113]);
    made.fire(120);
    expect([made.state, made.at_s]).toEqual(["held", 105]);
  });

  it("takes one picture after the other, none over the last, in normal mode", () => {
    const made = new Acquisition("normal", 2, 50, 0);
    made.advance(1);
    made.fire(4);
    expect(made.advance(5)).toEqual([3, 5]);
    made.fire(4.5);
    expect(made.state).toBe("waiting");
    made.fire(5.5);
    expect(made.advance(7)).toEqual([4.5, 6.5]);
    expect(made.isFree(100)).toBe(false);
  });

  it("moves on without a trigger in automatic mode, and lives through a clock that begins anew", () => {
    const made = new Acquisition("auto", 0.1, 0, 50);
    made.advance(50.1);
    expect([made.isFree(50.9), made.isFree(51.2)]).toEqual([false, true]);
    made.advance(0);
    made.fire(0.2);
    expect(made.advance(0.31)).toEqual([0.2, expect.closeTo(0.3)]);
  });
});

it("reads settings that were kept, whatever they are", () => {
  expect(readTrigger(null)).toBeUndefined();
  expect(readTrigger({ on: "moon", level: "7", edge: "falling", hysteresis: -2, before_percent: 900, step: 2.4 })).toEqual({
    ...USUAL_TRIGGER,
    edge: "falling",
    before_percent: 100,
    step: 2,
  });
});

it("says the state", () => {
  expect(stateText({ state: "armed", at_s: NaN }, 0)).toBe("armed");
  expect(stateText({ state: "held", at_s: 12.3456789 }, 0.0005)).toBe("triggered at 12.3457 s, ±0.5 ms");
  expect(stateText({ state: "waiting", at_s: 1 }, 0)).toBe("triggered at 1.0000 s; waiting");
});
