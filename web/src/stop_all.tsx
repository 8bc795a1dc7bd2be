/** Stop all: one button and one key for all that moves, from anywhere in the page. */

import { signal } from "@preact/signals";
import { notify, notifyError } from "./parts/notices";
import { hello, link } from "./store";

/** Stops that the bench has not answered yet. */
const waiting = signal(0);

/** Whether the user may stop anything: a viewer may not. What is shown may be past; what is stopped is present. */
export function mayStop(): boolean {
  return hello.value !== null && hello.value.role !== "viewer";
}

/** Stop all axes that move, and end all runs; say what was stopped, or that nothing could be sent. */
export async function stopAll(): Promise<void> {
  if (link.state.peek() !== "open") {
    notify("Stop all was NOT sent: there is no connection to the bench. What moves goes on moving.", true);
    return;
  }
  waiting.value += 1;
  try {
    const { stopped, runs, refused } = await link.ask("halt", "", { how: "grace" });
    const done = [...runs.map((name) => `run ${name}`), ...stopped];
    notify(done.length ? `Stop all: ${done.join(", ")}` : "Stop all: nothing moved");
    for (const [name, why] of Object.entries(refused)) notify(`Stop all: ${name} was not stopped: ${why}`, true);
  } catch (error) {
    notifyError(error);
  } finally {
    waiting.value -= 1;
  }
}

export function StopAll() {
  if (!mayStop()) return null;
  const isLost = link.state.value !== "open";
  const text = isLost ? "Cannot stop: no connection" : waiting.value ? "Stopping …" : "Stop all";
  return (
    <button
      type="button"
      class={isLost ? "stop-all is-lost" : "stop-all"}
      title="Stop all axes that move, and end all runs (Shift-Esc)"
      aria-keyshortcuts="Shift+Escape"
      onClick={() => void stopAll()}
    >
      {text}
    </button>
  );
}

/** Shift-Esc, also while something is typed, in a terminal or a dialog. Answers the function that ends it. */
export function onStopKey(): () => void {
  const onKey = (event: KeyboardEvent) => {
    if (event.key !== "Escape" || !event.shiftKey || event.ctrlKey || event.altKey || event.metaKey || !mayStop()) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (!event.repeat) void stopAll();
  };
  window.addEventListener("keydown", onKey, true);
  return () => window.removeEventListener("keydown", onKey, true);
}
