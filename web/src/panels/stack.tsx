/** Panels below each other, for a narrow screen. Those far out of sight show nothing. */

import { useEffect, useRef, useState } from "preact/hooks";
import { panelsOf } from "../model/layout";
import { appended, exchanged, without } from "../model/layout_change";
import { change, layout, setArranger } from "./desk";
import { titleOf } from "./kinds";
import { hasSettings, PanelBody, toggleSettings } from "./panel";

/** Panels begin to show what they have so far before they are in sight. */
const NEAR_PX = "200px";

function show(id: string): void {
  requestAnimationFrame(() => {
    const place = document.getElementById(`stack-${id}`);
    place?.scrollIntoView({ block: "nearest" });
    place?.querySelector<HTMLElement>("button")?.focus();
  });
}

export function Stack() {
  useEffect(() => {
    setArranger({
      add: (row) => {
        change(appended(layout.peek(), row));
        show(row.id);
      },
      close: (id) => change(without(layout.peek(), id)),
      show,
    });
    return () => setArranger(null);
  }, []);
  const rows = panelsOf(layout.value.root);
  return (
    <ol class="stack">
      {rows.map((row, at) => (
        <li key={row.id} id={`stack-${row.id}`} class={`card stacked of-${row.kind}`}>
          <div class="card-head">
            <h3>{titleOf(row)}</h3>
            <span class="push row">
              {hasSettings(row) && (
                <button type="button" class="plain" aria-label={`Settings of ${titleOf(row)}`} onClick={() => toggleSettings(row.id)}>
                  ⚙
                </button>
              )}
              <Mover text="↑" label={`Move ${titleOf(row)} up`} id={row.id} other={rows[at - 1]?.id} />
              <Mover text="↓" label={`Move ${titleOf(row)} down`} id={row.id} other={rows[at + 1]?.id} />
              <button type="button" class="plain" aria-label={`Close ${titleOf(row)}`} onClick={() => change(without(layout.peek(), row.id))}>
                ×
              </button>
            </span>
          </div>
          <Near id={row.id} />
        </li>
      ))}
    </ol>
  );
}

function Mover({ text, label, id, other }: { text: string; label: string; id: string; other: string | undefined }) {
  return (
    <button type="button" class="plain" aria-label={label} disabled={!other} onClick={() => other && change(exchanged(layout.peek(), id, other))}>
      {text}
    </button>
  );
}

/** A panel while it is near what is in sight. */
function Near({ id }: { id: string }) {
  const place = useRef<HTMLDivElement>(null);
  const [isNear, setNear] = useState(false);
  useEffect(() => {
    const observer = new IntersectionObserver((entries) => setNear(entries.at(-1)?.isIntersecting ?? false), { rootMargin: NEAR_PX });
    observer.observe(place.current!);
    return () => observer.disconnect();
  }, []);
  return (
    <div ref={place} class="panel-place">
      {isNear && <PanelBody id={id} />}
    </div>
  );
}
