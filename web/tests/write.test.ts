import { describe, expect, it } from "vitest";
import { write } from "../src/parts/write";

/** As much of an element as it looks at. */
function place() {
  const made = { firstChild: null as { nodeValue: string } | null, appended: 0 };
  return Object.assign(made, { append: (text: string) => ((made.firstChild = { nodeValue: text }), void made.appended++) });
}

describe("write", () => {
  it("changes the text that is there", () => {
    const there = place();
    for (const text of ["1.0", "1.0", "2.0", ""]) write(there as unknown as Element, text);
    expect(there.appended).toBe(1);
    expect(there.firstChild?.nodeValue).toBe("");
    write(null, "nobody");
  });
});
