/** Parts of the page that stand in places of the docking library. They are one tree with the rest: ids are unique. */

import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";

interface Mount {
  place: HTMLElement;
  part: ComponentChildren;
}

const mounts = signal<ReadonlyMap<string, Mount>>(new Map());

let keys = 0;

export function newKey(): string {
  return `part ${++keys}`;
}

/** Show a part in a place, in the stead of what this key had; null: nothing. */
export function mount(key: string, place: HTMLElement, part: ComponentChildren | null): void {
  const next = new Map(mounts.peek());
  if (part === null) next.delete(key);
  else next.set(key, { place, part });
  mounts.value = next;
}

export function Mounts() {
  return (
    <div hidden>
      {[...mounts.value].map(([key, { place, part }]) => (
        // The box of each stays here: what is in it is moved.
        <div key={key}>
          <Moved place={place}>{part}</Moved>
        </div>
      ))}
    </div>
  );
}

function Moved({ place, children }: { place: HTMLElement; children: ComponentChildren }) {
  const box = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => {
    const element = box.current;
    if (element) place.append(element);
    return () => element?.remove();
  }, [place]);
  return (
    <div ref={box} class="moved">
      {children}
    </div>
  );
}
