import { describe, expect, it } from "vitest";
import { marked, movedBack, readFaults, timesText } from "../src/model/fault_marks";

const fault = (number: number, begin_s: number | null = null) => ({ number, kind: "shaft_jam", target: "m1", parameters: {}, begin_s });

describe("fault marks", () => {
  it("begin and end with the list of active faults", () => {
    const first = marked([], [fault(1, 3)], 5);
    expect(first).toMatchObject([{ number: 1, begin_s: 3, end_s: null }]);
    const second = marked(first, [fault(1, 3), fault(2)], 6);
    expect(second).toMatchObject([{ end_s: null }, { number: 2, begin_s: 6, end_s: null }]);
    const third = marked(second, [fault(2)], 7);
    expect(third).toMatchObject([
      { number: 1, begin_s: 3, end_s: 7 },
      { number: 2, end_s: null },
    ]);
    expect(marked(third, [fault(1), fault(2)], 8)).toHaveLength(3);
  });

  it("stay where the samples of their time go, when the bench begins anew", () => {
    expect(movedBack([{ ...fault(1), begin_s: 3, end_s: null }], 10, 8)).toMatchObject([{ begin_s: -7, end_s: -2 }]);
  });

  it("are of the time that the bench tells", () => {
    expect(readFaults([{ number: 1, kind: "k", target: "t", parameters: {}, begin_ns: 2.5e9 }])).toMatchObject([{ begin_s: 2.5 }]);
  });

  it.each([
    [3, 4, "3.0 s to 4.0 s"],
    [3, 3, "at 3.0 s"],
    [3, null, "since 3.0 s"],
  ])("from %d to %d is %s", (begin_s, end_s, text) => {
    expect(timesText({ ...fault(1), begin_s, end_s })).toBe(text);
  });
});
