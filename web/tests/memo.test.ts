import { describe, expect, it } from "vitest";
import { memo } from "../src/parts/memo";

describe("memo", () => {
  const Memo = memo((_props: { row: object; at: number; note?: string }) => null);
  const row = {};

  it("is drawn again where a property changed, came or went", () => {
    const shown = new Memo({ row, at: 1 });
    shown.props = { row, at: 1 };
    expect(shown.shouldComponentUpdate({ row, at: 1 })).toBe(false);
    expect(shown.shouldComponentUpdate({ row: {}, at: 1 })).toBe(true);
    expect(shown.shouldComponentUpdate({ row, at: 1, note: "" })).toBe(true);
    shown.props = { row, at: 1, note: "" };
    expect(shown.shouldComponentUpdate({ row, at: 1 })).toBe(true);
  });
});
