/** Light and dark: what the system says, until the user chooses. */

import { effect, signal } from "@preact/signals";
import { remember, remembered } from "./kept";

export type Theme = "light" | "dark";

const KEY = "hil.theme";
const system = window.matchMedia("(prefers-color-scheme: dark)");

function chosen(): Theme | null {
  const kept = remembered(KEY);
  return kept === "light" || kept === "dark" ? kept : null;
}

const ofSystem = (): Theme => (system.matches ? "dark" : "light");

export const theme = signal<Theme>(chosen() ?? ofSystem());

system.addEventListener("change", () => {
  if (!chosen()) theme.value = ofSystem();
});

effect(() => {
  document.documentElement.dataset["theme"] = theme.value;
});

export function toggleTheme(): void {
  theme.value = theme.value === "dark" ? "light" : "dark";
  remember(KEY, theme.value);
}

/** Value of a colour of the style sheet, such as "--ink", for canvases. Read it again when `theme` changes. */
export function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
