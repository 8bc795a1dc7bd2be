import { describe, expect, it } from "vitest";
import type { ParameterRow } from "../src/model/door";
import { answerText } from "../src/model/answer_text";

const given = (unit: string) => ({ parameters: unit ? [{ name: "x", unit } as ParameterRow] : [] });
const SERVO = [{ name: "r" }, { name: "mode" }];

describe("what a verb answered", () => {
  it.each([
    [{ effective_at_ns: 5, set_point: 6.2841796875 }, "", SERVO, "set-point 6.284"],
    [{ set_point: 6.2841796875 }, "deg", SERVO, "set-point 6.28 deg"],
    [{ set_point: 30.5 }, "rpm", SERVO, "set-point 30.5 rpm"],
    [{ set_point: 90 }, "", [{ name: "r" }], "set-point 90 deg"],
    [{ position_deg: -0.001, is_on: true, name: "a b", free: 3 }, "", [], "position 0.00 deg, is on yes, name a b, free 3"],
    [{ rows: [[1]] }, "", [], "rows [[1]]"],
    [{ effective_at_ns: 5 }, "deg", SERVO, ""],
    [null, "", [], ""],
    ["x", "", [], ""],
  ])("%j of a verb in %j: %s", (answer, unit, fields, text) => expect(answerText(answer, given(unit), fields)).toBe(text));
});
