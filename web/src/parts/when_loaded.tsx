/** Components whose modules are loaded when they are first shown: the first view is light. */

import { signal } from "@preact/signals";
import type { ComponentType } from "preact";
import { useEffect } from "preact/hooks";

export function whenLoaded<Props extends object>(load: () => Promise<ComponentType<Props>>): ComponentType<Props> {
  const loaded = signal<{ Found: ComponentType<Props> } | null>(null);
  return function WhenLoaded(props: Props) {
    useEffect(() => {
      if (!loaded.peek())
        void load().then(
          (Found) => (loaded.value = { Found }),
          () => undefined, // a page of another version: the rest of the view is there
        );
    }, []);
    const found = loaded.value;
    return found ? <found.Found {...props} /> : null;
  };
}
