import { describe, expect, it } from "vitest";
import { codeOffers, explainedAt, tokenAt } from "../src/model/gcode_text";

function kinds(line: string): string[] {
  const found: string[] = [];
  for (let at = 0; at < line.length; ) {
    const token = tokenAt(line, at);
    expect(token.to).toBeGreaterThan(at);
    if (token.kind !== "other") found.push(`${line.slice(token.from, token.to)} ${token.kind}`);
    at = token.to;
  }
  return found;
}

describe("words of G-code", () => {
  it("are told apart", () => {
    expect(kinds("n10 g01 x-1.5 F1200 (to there) ; end")).toEqual([
      "n10 word",
      "g01 command",
      "x-1.5 axis",
      "F1200 word",
      "(to there) comment",
      "; end comment",
    ]);
    expect(kinds("#<depth> = [2 * SIN[#3]] G81")).toEqual([
      "#<depth> parameter",
      "= operator",
      "2 number",
      "* operator",
      "SIN function",
      "#3 parameter",
      "G81 refused",
    ]);
  });
  it("end in any text", () => {
    for (const line of ["\u0000\uffff%$&", "G", "((((", "#", "G1X", "ä X1", "a".repeat(3000)]) kinds(line);
  });
  it("are explained", () => {
    expect(explainedAt("G03 X1", 1)).toEqual({ from: 0, to: 3, text: "G3: arc counterclockwise: I J K or R, P turns (motion)" });
    expect(explainedAt("G59.1", 0)?.text).toBe("G59.1: coordinate system 7 (coordinates)");
    expect(explainedAt("G81 X1", 0)?.text).toContain("refused here: have the CAM program write its canned cycles as single moves");
    expect(explainedAt("M3 S900", 4)?.text).toBe("S: speed of the spindle, rpm");
    expect(explainedAt("H2", 0)?.text).toBe("H: no word here takes it: there is no tool table");
    expect(explainedAt("G123", 2)?.text).toBe("G123: there is no such word here");
    expect(explainedAt("G1 X1", 2)).toBeNull();
    expect(explainedAt("", 0)).toBeNull();
  });
  it("that are refused are not offered", () => {
    const names = codeOffers().map(({ name }) => name);
    expect(names).toContain("G64");
    expect(names).not.toContain("G81");
  });
});
