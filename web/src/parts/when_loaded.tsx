/** Components whose modules are loaded when they are first shown, or before it while the browser has nothing to do: the first
 * view is light, and a click does not wait. */

import { signal } from "@preact/signals";
import type { ComponentType } from "preact";
import { useEffect } from "preact/hooks";

/** Loads that nobody has asked for yet. */
const ahead: (() => Promise<void>)[] = [];

export function whenLoaded<Props extends object>(load: () => Promise<ComponentType<Props>>): ComponentType<Props> {
  const loaded = signal<{ Found: ComponentType<Props> } | "failed" | null>(null);
  const take = async () => {
    loaded.value = { Found: await load() };
  };
  ahead.push(take);
  return function WhenLoaded(props: Props) {
    useEffect(() => {
      if (!loaded.peek() || loaded.peek() === "failed") take().catch(() => (loaded.value = "failed"));
    }, []);
    const found = loaded.value;
    if (found === "failed") return <p class="problem">This part could not be loaded: load the page again.</p>;
    return found ? <found.Found {...props} /> : null;
  };
}

/** Load one after another what was not shown yet. One that fails is loaded again, and says so, when it is shown. */
export function loadAhead(): void {
  const take = ahead.shift();
  if (!take) return;
  const begin = () =>
    void take()
      .catch(() => undefined)
      .finally(loadAhead);
  if ("requestIdleCallback" in window) window.requestIdleCallback(begin);
  else setTimeout(begin); // Safari
}
