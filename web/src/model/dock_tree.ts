/** Layouts as the docking library has them, and back. Its parts have sizes in pixels. Pure. */

import { isTabs, type PanelRow, type Place, sharesOf } from "./layout";

/** A place of the library: parts, or panels in tabs. */
export interface DockPlace {
  type: "leaf" | "branch";
  data: DockPlace[] | DockTabs;
  size?: number;
}

interface DockTabs {
  id: string;
  views: string[];
  activeView?: string;
}

export interface DockGrid {
  root: DockPlace;
  width: number;
  height: number;
  orientation: "HORIZONTAL" | "VERTICAL";
}

/** Make the library's grid of a layout's root for a room of some pixels. */
export function gridOf(root: Place, isColumn: boolean, width: number, height: number): DockGrid {
  let groups = 0;
  const made = (place: Place, along: number, across: number, size: number): DockPlace => {
    if (isTabs(place)) {
      const views = place.tabs.map(({ id }) => id);
      return { type: "leaf", data: { id: `g${++groups}`, views, activeView: views[place.shown]! }, size };
    }
    const sum = place.shares.reduce((all, each) => all + each, 0);
    // A part of a part lies along the other side.
    const parts = place.parts.map((part, at) => {
      const long = ((place.shares[at] ?? 0) / sum) * along;
      return made(part, across, long, long);
    });
    return { type: "branch", data: parts, size };
  };
  const [along, across] = isColumn ? [height, width] : [width, height];
  const whole: Place = isTabs(root) ? { parts: [root], shares: [1000] } : root;
  return { root: made(whole, along, across, across), width, height, orientation: isColumn ? "VERTICAL" : "HORIZONTAL" };
}

/** Read the library's grid again: the panels by their ids. */
export function placeOf(grid: DockGrid, rowOf: (id: string) => PanelRow | undefined): { root: Place | null; isColumn: boolean } {
  const read = (place: DockPlace): Place | null => {
    if (!Array.isArray(place.data)) {
      const { views, activeView } = place.data;
      const rows = views.flatMap((id) => rowOf(id) ?? []);
      if (!rows.length) return null;
      return {
        tabs: rows,
        shown: Math.max(
          rows.findIndex(({ id }) => id === activeView),
          0,
        ),
      };
    }
    const parts = place.data.map((part): [Place | null, number] => [read(part), part.size ?? 0]);
    const there = parts.filter((part): part is [Place, number] => part[0] !== null);
    if (!there.length) return null;
    return {
      parts: there.map(([part]) => part),
      shares: sharesOf(
        there.map(([, size]) => size),
        there.length,
      ),
    };
  };
  const root = read(grid.root);
  const isOne = root !== null && !isTabs(root) && root.parts.length === 1 && isTabs(root.parts[0]!);
  return { root: isOne ? root.parts[0]! : root, isColumn: grid.orientation === "VERTICAL" };
}
