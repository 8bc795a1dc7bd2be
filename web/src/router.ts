/** Place in the page as the part of the address after "#": "#/bench/m1". */

import { signal } from "@preact/signals";

function read(): string[] {
  const parts = window.location.hash.replace(/^#\/?/, "").split("/");
  return parts
    .filter((part) => part !== "")
    .map((part) => {
      try {
        return decodeURIComponent(part);
      } catch {
        return part;
      }
    });
}

/** View and what it shows: ["bench", "m1"]. */
export const path = signal<string[]>(read());

window.addEventListener("hashchange", () => {
  path.value = read();
});

/** Make the address of a place, for links. Half a surrogate pair has none: it is replaced. */
export function href(...parts: string[]): string {
  return `#/${parts.map((part) => encodeURIComponent(part.replace(/\p{Surrogate}/gu, "\ufffd"))).join("/")}`;
}

export function go(...parts: string[]): void {
  window.location.hash = href(...parts);
}
