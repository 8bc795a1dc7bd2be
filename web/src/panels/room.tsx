/** The room of the panels: what can be done with the layout, and the panels themselves, docked or in a stack. */

import { signal } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { panelsOf } from "../model/layout";
import { hello } from "../store";
import { layout, openAddress, openings, setArranger, trouble } from "./desk";
import type { Dock } from "./dock";
import { Mounts } from "./mounts";
import { Stack } from "./stack";
import { ReadyLinks, Toolbar } from "./toolbar";
import "./panels.css";

/** Below this width panels stand in a stack. */
const NARROW = window.matchMedia("(max-width: 640px)");
const isNarrow = signal(NARROW.matches);
NARROW.addEventListener("change", () => (isNarrow.value = NARROW.matches));

export function Room({ address }: { address: string[] }) {
  const place = useRef<HTMLDivElement>(null);
  const bench = hello.value?.bench;
  useEffect(() => void openAddress(address), [address.join("/"), bench]);
  const isEmpty = panelsOf(layout.value.root).length === 0;
  return (
    <div ref={place} class={layout.value.isWatch ? "room is-watch" : "room"}>
      <Toolbar fill={() => void place.current?.requestFullscreen().catch(() => undefined)} />
      <Trouble />
      {isEmpty && openings.value > 0 && <p class="empty">This layout has no panels. Add one by + Panel, or open another:</p>}
      {isEmpty && openings.value > 0 && <ReadyLinks />}
      {openings.value > 0 && (isNarrow.value ? <Stack key={openings.value} /> : <Docked key={openings.value} />)}
      <Mounts />
    </div>
  );
}

function Trouble() {
  if (!trouble.value) return null;
  return (
    <div class="card" role="alert">
      <p class="problem">{trouble.value}</p>
      <p>What you had before is below. Or open another:</p>
      <ReadyLinks />
      <button type="button" onClick={() => (trouble.value = "")}>
        Close this message
      </button>
    </div>
  );
}

function Docked() {
  const place = useRef<HTMLDivElement>(null);
  const [why, setWhy] = useState("");
  useEffect(() => {
    let dock: Dock | null = null;
    let isEnded = false;
    import("./dock")
      .then((code) => {
        if (isEnded || !place.current) return;
        dock = new code.Dock(place.current);
        setArranger(dock);
      })
      .catch((error: unknown) => setWhy(`The panels could not be shown: ${String(error)}`));
    const onKey = (event: KeyboardEvent) => {
      if (event.key !== "F6" || !dock) return;
      event.preventDefault();
      dock.goOn(event.shiftKey ? -1 : 1);
    };
    window.addEventListener("keydown", onKey);
    return () => {
      isEnded = true;
      window.removeEventListener("keydown", onKey);
      setArranger(null);
      dock?.end();
    };
  }, []);
  return (
    <>
      {why && <p class="problem">{why}</p>}
      <div ref={place} class={panelsOf(layout.value.root).length ? "dock" : "dock is-empty"} />
    </>
  );
}
