/** Title and icon of the browser's tab: they tell of trouble while another tab is looked at. */

import { type Health, reasonText } from "./model/status";
import type { LinkState } from "./net/channels";

/** Bounds of a title: a tab shows a few words. */
const MOST_CHARACTERS = 60;
const INK = { fine: "#0a5fb4", bad: "#c62828", lost: "#7a8590" };

/** What is wrong. `what`: the first problem of the bench, in words; empty: it is not told. */
export interface TabTrouble {
  kind: "" | "failed" | "no connection";
  what: string;
}

/** What is wrong, if anything is. A bench that is late now and then is no trouble. */
export function tabTrouble(link: LinkState, health: Pick<Health, "state" | "problems"> | undefined): TabTrouble {
  if (link === "lost") return { kind: "no connection", what: "" };
  if (health?.state !== "failed" || link !== "open") return { kind: "", what: "" };
  const [first] = health.problems;
  return { kind: "failed", what: first ? reasonText(first) : "" };
}

/** Title: what failed, as "m1: stopped: …", before the bench's name; a tab may show its begin alone. */
export function tabTitle(bench: string, { kind, what }: TabTrouble): string {
  const name = bench ? `${bench.slice(0, MOST_CHARACTERS)} · hil` : "hil";
  if (!kind) return name;
  return `${what ? `✗ ${what.slice(0, MOST_CHARACTERS)}` : kind}: ${name}`;
}

/** A shaft with its mark, in the colour of the trouble; a bar through it where something is wrong. */
export function tabIcon(trouble: TabTrouble["kind"]): string {
  const ink = trouble === "" ? INK.fine : trouble === "failed" ? INK.bad : INK.lost;
  const bar = trouble === "" ? "" : '<path d="M3 13 13 3" stroke="#fff" stroke-width="2.5"/>';
  const mark = '<path d="M8 8 12 4" stroke="#fff" stroke-width="2"/>';
  const picture = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 16 16"><circle cx="8" cy="8" r="7" fill="${ink}"/>${bar || mark}</svg>`;
  return `data:image/svg+xml,${encodeURIComponent(picture)}`;
}

export function showTabIcon(trouble: TabTrouble["kind"]): void {
  document.getElementById("icon")?.setAttribute("href", tabIcon(trouble));
}
