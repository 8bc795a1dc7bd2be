import { describe, expect, it } from "vitest";
import { tabIcon, tabTitle, tabTrouble } from "../src/tab_head";

describe("the tab's title and icon", () => {
  const problems = [{ about: "m1", what: "stopped: it hung", remedy: "`hil reset m1`" }];

  it.each([
    ["open", "ok", "demo · hil"],
    ["open", undefined, "demo · hil"],
    ["open", "late", "demo · hil"],
    ["open", "failed", "failed: demo · hil"],
    ["lost", "ok", "no connection: demo · hil"],
    ["connecting", "failed", "demo · hil"],
  ] as const)("of a link that is %s, a bench that is %s", (link, health, title) => {
    expect(tabTitle("demo", tabTrouble(link, health && { state: health, problems: [] }))).toBe(title);
  });

  it("say what failed", () => {
    expect(tabTitle("demo", tabTrouble("open", { state: "failed", problems }))).toBe("✗ m1: stopped: it hung: demo · hil");
    expect(tabTrouble("lost", { state: "failed", problems })).toEqual({ kind: "no connection", what: "" });
  });

  it("are bounded, and a page without a bench has them", () => {
    const fine = tabTrouble("open", undefined);
    expect(tabTitle("x".repeat(5000), fine).length).toBeLessThan(70);
    expect(tabTitle("x".repeat(5000), { kind: "failed", what: "x".repeat(5000) }).length).toBeLessThan(140);
    expect(tabTitle("", fine)).toBe("hil");
    expect(new Set((["", "failed", "no connection"] as const).map(tabIcon)).size).toBe(3);
  });
});
