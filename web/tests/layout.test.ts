import { expect, it } from "vitest";
import { gridOf, placeOf } from "../src/model/dock_tree";
import { emptyLayout, type Layout, MOST_PANELS, panel, panelsOf, readLayout, split, tabs, Unreadable } from "../src/model/layout";
import { appended, exchanged, isAlike, isFull, numbered, sizedAs, without, withPanel } from "../src/model/layout_change";
import { isLayoutText, layoutOfText, textOfLayout } from "../src/model/layout_text";

const made = (): Layout =>
  numbered({
    ...emptyLayout("demo", "mine"),
    root: split(
      [60, tabs(panel("plot", "", { signals: ["m1.yw"] }), panel("wire", "bus0"))],
      [40, split([1, tabs(panel("number", "m1.yw"))], [3, tabs(panel("events"))])],
    ),
  });
const ids = (layout: Layout) => panelsOf(layout.root).map(({ id, kind }) => `${id} ${kind}`);

it("survives the way through an address, with all that it has", async () => {
  const text = await textOfLayout({ ...made(), name: "Prüfstand ⚙", isWatch: true });
  expect(isLayoutText(text)).toBe(true);
  expect(text).toMatch(/^1\.[\w-]+$/);
  expect(numbered(await layoutOfText(text))).toEqual({ ...made(), name: "Prüfstand ⚙", isWatch: true });
});

it.each([
  ["2.abc", /version 2; this page reads version 1/],
  ["1.", /no layout that can be read/],
  ["1.AAAA", /no layout that can be read/],
  ["1.!!!", /no layout that can be read/],
])("says why the address %s has no layout", async (text, why) => {
  await expect(layoutOfText(text)).rejects.toThrow(why);
  await expect(layoutOfText(text)).rejects.toBeInstanceOf(Unreadable);
});

it("refuses an address that would fill the memory", async () => {
  const bomb = await textOfLayout({ ...made(), name: "x".repeat(2_000_000) });
  await expect(layoutOfText(bomb)).rejects.toThrow(/too large/);
});

it.each([null, 1, "x", [], {}, { version: 7 }])("refuses %j as a layout", (raw) => {
  expect(() => readLayout(raw)).toThrow(Unreadable);
});

it("leaves out what is no panel, and takes sizes that are none as equal", () => {
  const raw = {
    version: 1,
    root: {
      parts: [{ tabs: [{ kind: "plot" }, { kind: "bomb" }, 3], shown: 99 }, { parts: [] }, { tabs: [{ kind: "events", of: 5, given: [] }] }],
      shares: [NaN, -1],
    },
  };
  const read = readLayout(raw);
  expect(read.root).toEqual({ parts: [tabs(panel("plot")), tabs(panel("events"))], shares: [500, 500] });
});

it("shows some of a thousand panels, and keeps the others", async () => {
  const rows = Array.from({ length: 1000 }, (_, at) => panel("number", `m${at}.yw`));
  const read = readLayout(JSON.parse(JSON.stringify({ ...emptyLayout("b"), root: tabs(...rows) })));
  expect(panelsOf(read.root)).toHaveLength(MOST_PANELS);
  expect(isFull(read)).toBe(true);
  expect(panelsOf(read.root).concat(read.waiting)).toEqual(rows);
  expect((await layoutOfText(await textOfLayout(read))).waiting).toEqual(read.waiting);
});

it("is bounded in depth", () => {
  let root: unknown = { tabs: [{ kind: "plot" }] };
  for (let depth = 0; depth < 5000; depth++) root = { parts: [root] };
  expect(readLayout({ version: 1, root }).root).toBeNull();
});

it("becomes a grid of the docking library, and comes back", () => {
  const { root, isColumn } = made();
  const grid = gridOf(root!, isColumn, 1000, 800);
  expect(grid.root.size).toBe(800);
  expect((grid.root.data as { size: number }[]).map(({ size }) => size)).toEqual([600, 400]);
  const rows = new Map(panelsOf(root).map((row) => [row.id, row]));
  expect(placeOf(grid, (id) => rows.get(id))).toEqual({ root, isColumn });
});

it("keeps its sizes in a window that has other ones", () => {
  const { root } = made();
  const grid = gridOf(root!, false, 300, 200);
  (grid.root.data as { size: number }[])[0]!.size = 100;
  const rows = new Map(panelsOf(root).map((row) => [row.id, row]));
  const squeezed = placeOf(grid, (id) => rows.get(id)).root;
  expect(squeezed).not.toEqual(root);
  expect(sizedAs(squeezed, root)).toEqual(root);
  expect(sizedAs(tabs(panel("plot")), root)).toEqual(tabs(panel("plot")));
});

it("is changed panel by panel", () => {
  const before = made();
  expect(ids(before)).toEqual(["p1 plot", "p2 wire", "p3 number", "p4 events"]);
  expect(ids(exchanged(before, "p1", "p4"))).toEqual(["p4 events", "p2 wire", "p3 number", "p1 plot"]);
  expect(ids(without(without(before, "p3"), "p2"))).toEqual(["p1 plot", "p4 events"]);
  expect(without(without(without(without(before, "p1"), "p2"), "p3"), "p4").root).toBeNull();
  expect(ids(appended(before, { ...panel("runs"), id: "p9" })).at(-1)).toBe("p9 runs");
  expect(panelsOf(withPanel(before, "p2", { of: "can0" }).root)[1]?.of).toBe("can0");
  expect(isAlike(before, made())).toBe(true);
  expect(isAlike(before, withPanel(made(), "p2", { of: "can0" }))).toBe(false);
});
