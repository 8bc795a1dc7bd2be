/** Changes of layouts: each makes another one. Pure. */

import { isTabs, type Layout, MOST_PANELS, type PanelRow, panelsOf, type Place, sharesOf, split } from "./layout";

/** Shares that differ by less are the same: sizes are whole pixels. */
const SAME_SHARE = 30;

/** Give each panel an id of its own, "p1" and so on; those that have one keep it. */
export function numbered(layout: Layout): Layout {
  const known = new Set<string>();
  let next = 1;
  const own = (row: PanelRow): PanelRow => {
    if (row.id && !known.has(row.id)) {
      known.add(row.id);
      return row;
    }
    while (known.has(`p${next}`)) next++;
    known.add(`p${next}`);
    return { ...row, id: `p${next}` };
  };
  return { ...layout, root: mapped(layout.root, own), waiting: layout.waiting.map((row) => ({ ...row, id: "" })) };
}

function mapped(place: Place | null, change: (row: PanelRow) => PanelRow): Place | null {
  if (!place) return null;
  if (isTabs(place)) return { ...place, tabs: place.tabs.map(change) };
  return { ...place, parts: place.parts.map((part) => mapped(part, change)!) };
}

/** Let a panel show something else. */
export function withPanel(layout: Layout, id: string, change: Partial<Pick<PanelRow, "of" | "given">>): Layout {
  return { ...layout, root: mapped(layout.root, (row) => (row.id === id ? { ...row, ...change } : row)) };
}

/** Exchange two panels. */
export function exchanged(layout: Layout, id: string, other: string): Layout {
  const rows = new Map(panelsOf(layout.root).map((row) => [row.id, row]));
  const [one, two] = [rows.get(id), rows.get(other)];
  if (!one || !two) return layout;
  return { ...layout, root: mapped(layout.root, (row) => (row === one ? two : row === two ? one : row)) };
}

/** Close a panel. */
export function without(layout: Layout, id: string): Layout {
  const cut = (place: Place | null): Place | null => {
    if (!place) return null;
    if (!isTabs(place)) return split(...place.parts.map((part, at): [number, Place | null] => [place.shares[at] ?? 1, cut(part)]));
    const rows = place.tabs.filter((row) => row.id !== id);
    return rows.length ? { tabs: rows, shown: Math.min(place.shown, rows.length - 1) } : null;
  };
  return { ...layout, root: cut(layout.root) };
}

/** Add a panel behind all others. */
export function appended(layout: Layout, row: PanelRow): Layout {
  const place: Place = { tabs: [row], shown: 0 };
  const { root } = layout;
  if (!root) return { ...layout, root: place };
  if (isTabs(root)) return { ...layout, root: { parts: [root, place], shares: sharesOf([1, 1], 2) } };
  const mean = root.shares.reduce((sum, each) => sum + each, 0) / root.shares.length;
  return { ...layout, root: { parts: [...root.parts, place], shares: sharesOf([...root.shares, mean], root.parts.length + 1) } };
}

/** Whether there is no room for another panel. */
export function isFull(layout: Layout): boolean {
  return panelsOf(layout.root).length >= MOST_PANELS;
}

/** Whether two layouts show the same in the same places; sizes may differ by little. */
export function isAlike(one: Layout, other: Layout): boolean {
  const rest = ({ name, isWatch, waiting }: Layout) => JSON.stringify([name, isWatch, waiting.map(rowText)]);
  const sameWay = one.isColumn === other.isColumn || !one.root || isTabs(one.root);
  return rest(one) === rest(other) && sameWay && isAlikePlace(one.root, other.root);
}

/** The same with keys in one order, and without what is the same for all. */
function rowText(row: PanelRow): string {
  const given = Object.entries(row.given).sort(([one], [other]) => (one < other ? -1 : 1));
  return JSON.stringify([row.kind, row.of, given]);
}

function isAlikePlace(one: Place | null, other: Place | null): boolean {
  if (!one || !other) return one === other;
  if (isTabs(one)) {
    return isTabs(other) && one.tabs.map(rowText).join() === other.tabs.map(rowText).join();
  }
  return (
    !isTabs(other) &&
    one.parts.length === other.parts.length &&
    one.parts.every((part, at) => isAlikePlace(part, other.parts[at]!) && Math.abs(one.shares[at]! - other.shares[at]!) <= SAME_SHARE)
  );
}

/** The same places with the sizes that they had before, where they are the same places: a window of another size
 * rounds them, and moves them where a panel has its least size. */
export function sizedAs(place: Place | null, before: Place | null): Place | null {
  if (!place || !before || isTabs(place) || isTabs(before) || place.parts.length !== before.parts.length) return place;
  return { shares: before.shares, parts: place.parts.map((part, at) => sizedAs(part, before.parts[at]!)!) };
}
