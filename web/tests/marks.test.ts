import { describe, expect, it } from "vitest";
import { injected, marked, movedBack, timesText } from "../src/model/fault_marks";

const fault = (number: number) => ({ number, kind: "shaft_jam", target: "m1", parameters: {} });

describe("fault marks", () => {
  it("begin and end with the list of active faults", () => {
    const first = marked([], [fault(1)], () => -Infinity, 5);
    expect(first).toMatchObject([{ number: 1, begin_s: -Infinity, end_s: null }]);
    const second = marked(first, [fault(1), fault(2)], () => 6, 6);
    expect(second).toMatchObject([{ end_s: null }, { number: 2, begin_s: 6, end_s: null }]);
    const third = marked(second, [fault(2)], () => 7, 7);
    expect(third).toMatchObject([{ number: 1, end_s: 7 }, { number: 2, end_s: null }]);
    expect(marked(third, [fault(1), fault(2)], () => 8, 8)).toHaveLength(3);
  });

  it("stay where the samples of their time go, when the bench begins anew", () => {
    expect(movedBack([{ ...fault(1), begin_s: 3, end_s: null }], 10, 8)).toMatchObject([{ begin_s: -7, end_s: -2 }]);
  });

  it("begin when their delay is over, exactly when the bench says so", () => {
    const late = { ...fault(1), parameters: { start_s: 2 } };
    const marks = marked([], [late], () => 5, 5);
    expect(marks).toMatchObject([{ begin_s: 7 }]);
    expect(injected(marks, 1, late.parameters, 4.9)).toMatchObject([{ begin_s: 6.9 }]);
    expect(injected(marks, 2, {}, 4.9)).toEqual(marks);
  });

  it.each([[3, 4, "3.0 s to 4.0 s"], [3, 3, "at 3.0 s"], [3, null, "since 3.0 s"], [-Infinity, null, "since before this page was opened"]])("from %d to %d is %s", (begin_s, end_s, text) => {
    expect(timesText({ ...fault(1), begin_s, end_s })).toBe(text);
  });
});
