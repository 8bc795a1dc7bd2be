import type { ViewEntry } from "../view";

function View() {
  return <p>faults</p>;
}

export const faultsView: ViewEntry = { id: "faults", title: "Faults", View };
