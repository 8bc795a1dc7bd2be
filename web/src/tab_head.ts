/** Title and icon of the browser's tab: they tell of trouble while another tab is looked at. */

import type { LinkState } from "./net/channels";

/** Bounds of a title: a tab shows a few words. */
const MOST_CHARACTERS = 60;
const INK = { fine: "#0a5fb4", bad: "#c62828", lost: "#7a8590" };

/** What is wrong, in a word or two; empty: nothing is. A bench that is late now and then is no trouble. */
export function tabTrouble(link: LinkState, health: string | undefined): string {
  if (link === "lost") return "no connection";
  return health === "failed" && link === "open" ? health : "";
}

export function tabTitle(bench: string, trouble: string): string {
  const name = bench ? `${bench.slice(0, MOST_CHARACTERS)} · hil` : "hil";
  return trouble ? `${trouble}: ${name}` : name;
}

/** A shaft with its mark, in the colour of the trouble; a bar through it where something is wrong. */
export function tabIcon(trouble: string): string {
  const ink = trouble === "" ? INK.fine : trouble === "failed" ? INK.bad : INK.lost;
  const bar = trouble === "" ? "" : '<path d="M3 13 13 3" stroke="#fff" stroke-width="2.5"/>';
  const mark = '<path d="M8 8 12 4" stroke="#fff" stroke-width="2"/>';
  const picture = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 16 16"><circle cx="8" cy="8" r="7" fill="${ink}"/>${bar || mark}</svg>`;
  return `data:image/svg+xml,${encodeURIComponent(picture)}`;
}

export function showTabIcon(trouble: string): void {
  document.getElementById("icon")?.setAttribute("href", tabIcon(trouble));
}
