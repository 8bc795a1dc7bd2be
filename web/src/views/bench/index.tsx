import type { ViewEntry } from "../view";

function View() {
  return <p>bench</p>;
}

export const benchView: ViewEntry = { id: "bench", title: "Bench", View };
