/** Components whose modules are loaded when they are first shown: the first view is light. */

import { signal } from "@preact/signals";
import type { ComponentType } from "preact";
import { useEffect } from "preact/hooks";

export function whenLoaded<Props extends object>(load: () => Promise<ComponentType<Props>>): ComponentType<Props> {
  const loaded = signal<{ Found: ComponentType<Props> } | "failed" | null>(null);
  return function WhenLoaded(props: Props) {
    useEffect(() => {
      if (!loaded.peek() || loaded.peek() === "failed")
        void load().then(
          (Found) => (loaded.value = { Found }),
          () => (loaded.value = "failed"),
        );
    }, []);
    const found = loaded.value;
    if (found === "failed") return <p class="problem">This part could not be loaded: load the page again.</p>;
    return found ? <found.Found {...props} /> : null;
  };
}
