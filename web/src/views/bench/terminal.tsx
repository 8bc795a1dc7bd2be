/** A terminal for any place of the page: its code, half of the page's, is loaded when somebody opens one. */

import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { pastAt } from "../../past";
import { may } from "../../store";
import { PastTerminal } from "./past_terminal";
import type { TerminalProps } from "./terminal_view";

const code = signal<typeof import("./terminal_view") | null>(null);
const whyNoCode = signal("");

async function loadCode(): Promise<void> {
  whyNoCode.value = "";
  try {
    code.value = await import("./terminal_view");
  } catch {
    whyNoCode.value = "The terminal could not be loaded: load the page again.";
  }
}

/** Terminal at a port, which fills what it stands in. Where the page looks back it has the words of then. */
export function Terminal(given: TerminalProps) {
  const isPast = pastAt.value !== null;
  const isAllowed = may("operator");
  useEffect(() => {
    if (!isPast && isAllowed && !code.peek()) void loadCode();
  }, [isPast, isAllowed]);
  if (isPast) return <PastTerminal key={given.port} port={given.port} />;
  if (!isAllowed) return <p class="soft">A terminal needs the role operator.</p>;
  if (code.value) return <code.value.TerminalView {...given} />;
  return <p class={whyNoCode.value ? "problem" : "soft"}>{whyNoCode.value || "The terminal is loaded …"}</p>;
}
