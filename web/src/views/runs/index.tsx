import type { ViewEntry } from "../view";

function View() {
  return <p>runs</p>;
}

export const runsView: ViewEntry = { id: "runs", title: "Runs", View };
