/** Stop all: one button and one key for all that moves, from anywhere in the page. */

import { computed, signal } from "@preact/signals";
import { notify, notifyError } from "./parts/notices";
import { hello, link, status } from "./store";

/** Stops that the bench has not answered yet. */
const waiting = signal(0);
const siteWaiting = signal(0);
const isJoined = computed(() => status.value.doors.some(({ isJoined }) => isJoined));

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

/** Stop all that moves on all benches of the site, and say which have confirmed. */
async function stopSite(): Promise<void> {
  if (link.state.peek() !== "open") {
    notify("Stop site was NOT sent: there is no connection to the bench. What moves goes on moving.", true);
    return;
  }
  siteWaiting.value += 1;
  try {
    const { benches } = await link.ask("stop_site", "", { how: "grace" });
    const confirmed = benches.filter(({ state }) => state === "confirmed").map(({ bench }) => bench);
    notify(`Stop site: ${confirmed.length} of ${benches.length} confirmed: ${confirmed.join(", ")}`);
    const others = benches.filter(({ state }) => state !== "confirmed").map(({ bench, why }) => `${bench}: ${why}`);
    if (others.length) notify(`Stop site: NOT confirmed: ${others.join("; ")}`, true);
    const refused = benches.flatMap(({ bench, refused }) => Object.entries(refused).map(([name, why]) => `${bench}/${name}: ${why}`));
    if (refused.length) notify(`Stop site: not stopped: ${refused.join("; ")}`, true);
  } catch (error) {
    notifyError(error);
  } finally {
    siteWaiting.value -= 1;
  }
}

/** The same for all benches, where this one is joined to a router. */
export function StopSite() {
  if (!mayStop() || !isJoined.value) return null;
  return (
    <button
      type="button"
      class={link.state.value === "open" ? "stop-all" : "stop-all is-lost"}
      title="Stop all that moves on all benches of the site"
      onClick={() => void stopSite()}
    >
      {siteWaiting.value ? "Stopping …" : "Stop site"}
    </button>
  );
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
