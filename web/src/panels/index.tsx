/** The view of panels that one arranges. Its code is loaded when somebody looks. */

import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { ViewEntry } from "../views/view";

const code = signal<typeof import("./room") | null>(null);
const whyNoCode = signal("");

async function load(): Promise<void> {
  whyNoCode.value = "";
  try {
    code.value = await import("./room");
  } catch {
    whyNoCode.value = "The panels could not be loaded: load the page again.";
  }
}

function LayoutView({ path }: { path: string[] }) {
  useEffect(() => void (code.peek() ?? load()), []);
  if (code.value) return <code.value.Room address={path} />;
  return <p class={whyNoCode.value ? "problem" : "soft"}>{whyNoCode.value || "The panels are loaded …"}</p>;
}

export const layoutView: ViewEntry = { id: "layout", title: "Layout", View: LayoutView };
