import { describe, expect, it } from "vitest";
import { tabIcon, tabTitle, tabTrouble } from "../src/tab_head";

describe("the tab's title and icon", () => {
  it.each([
    ["open", "ok", "demo · hil"],
    ["open", undefined, "demo · hil"],
    ["open", "late", "demo · hil"],
    ["open", "failed", "failed: demo · hil"],
    ["lost", "ok", "no connection: demo · hil"],
    ["connecting", "failed", "demo · hil"],
  ] as const)("of a link that is %s, a bench that is %s", (link, health, title) => {
    expect(tabTitle("demo", tabTrouble(link, health))).toBe(title);
  });

  it("are bounded, and a page without a bench has them", () => {
    expect(tabTitle("x".repeat(5000), "").length).toBeLessThan(70);
    expect(tabTitle("", "")).toBe("hil");
    expect(new Set(["", "failed", "no connection"].map(tabIcon)).size).toBe(3);
  });
});
