/** The time line of the run: what happened, and the time that the page shows. */

import { signal } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { agoText, markBeside, type PastMark, timeText } from "../../model/past";
import { keptText } from "../../kept";
import { notifyError } from "../../parts/notices";
import { askPast, end_s, followOverview, LANE, live, lookAt, marks, pace, pastAt, ready_s, trouble } from "../../past";
import { hello } from "../../store";
import { theme } from "../../theme";
import { LineCanvas } from "./line_canvas";
import "./past.css";

/** Times that are in sight: from a time to another, or all of the run. */
const window_s = signal<[number, number] | null>(null);
const said = signal("");
const condition = keptText("past.condition");
const PACES = [0.01, 0.1, 0.5, 1, 2, 10, 100];
const chosenPace = signal(1);
const LEAST_s = 0.05;
/** Whether its controls are shown where the screen is narrow; else they are in any case. */
const isOpen = signal(false);

export function TimeLine() {
  useEffect(followOverview, []);
  if (!end_s.value) {
    return trouble.value ? <p class="soft time-line-none">No time line: {trouble.value}</p> : null;
  }
  return (
    <section class={`time-line ${isOpen.value ? "" : "is-small"}`} aria-label="Time line of the run">
      <button
        type="button"
        class="plain time-line-more"
        aria-expanded={isOpen.value}
        aria-controls="time-line-controls"
        onClick={() => (isOpen.value = !isOpen.value)}
      >
        {isOpen.value ? "▾" : "▴"} Time line, {pastAt.value === null ? "live" : timeText(pastAt.value)}
      </button>
      <Controls />
      <Line />
    </section>
  );
}

/** What stands above the page while it shows the past. */
export function PastBanner() {
  const at = pastAt.value;
  if (at === null) return null;
  return (
    <div class="past-banner" role="status">
      <span>
        {agoText(end_s.value - at)} ago: <span class="mono">{timeText(at)}</span>
      </span>
      <span class="soft">what you see is from then, nothing can be done there</span>
      <button type="button" onClick={live}>
        Back to live
      </button>
    </div>
  );
}

function shown(): [number, number] {
  return window_s.value ?? [0, Math.max(end_s.value, 1)];
}

function zoom(factor: number): void {
  const [from, to] = shown();
  const end = Math.max(end_s.peek(), 1);
  const around = pastAt.peek() ?? to;
  const span = Math.max((to - from) * factor, LEAST_s);
  if (span >= end) {
    window_s.value = null;
    return;
  }
  const left = Math.min(Math.max(around - (around - from) * (span / (to - from)), 0), end - span);
  window_s.value = [left, left + span];
}

/** Move the window so that a time is in sight. */
function reveal(at_s: number): void {
  const now = window_s.peek();
  if (!now || (at_s >= now[0] && at_s <= now[1])) return;
  const half = (now[1] - now[0]) / 2;
  window_s.value = [Math.max(at_s - half, 0), Math.max(at_s - half, 0) + 2 * half];
}

function goTo(at_s: number): void {
  pace.value = 0;
  lookAt(at_s);
  reveal(at_s);
}

function jump(isBack: boolean): void {
  const mark = markBeside(marks.peek(), pastAt.peek() ?? end_s.peek(), isBack);
  if (!mark) {
    said.value = isBack ? "Nothing happened before." : "Nothing happened behind it.";
    return;
  }
  goTo(mark.from_s);
  said.value = textOf(mark);
}

function textOf(mark: PastMark): string {
  return `${timeText(mark.from_s)} ${mark.lane}: ${mark.text}`;
}

let search = 0;

/** Find a time, and say what was found, or why nothing can be. */
function find(isBack: boolean): void {
  findTime(isBack).catch((error: Error) => (said.value = error.message));
}

/** Go to the next, or the last, time at which the condition begins to hold. */
async function findTime(isBack: boolean): Promise<void> {
  const own = ++search;
  let from_s = pastAt.peek() ?? (isBack ? end_s.peek() : 0);
  while (own === search) {
    const told = await askPast("past_find", { condition: condition.peek(), from_s, back: isBack, lane: LANE });
    if (own !== search || !told) return;
    if (told.found_ns !== null) {
      goTo(told.found_ns / 1e9);
      said.value = `${timeText(told.found_ns / 1e9)}: ${condition.peek()}`;
      return;
    }
    const isOver = isBack ? told.looked_from_ns <= 0 : told.looked_to_ns >= told.end_ns;
    if (isOver) {
      said.value = `“${condition.peek()}” does not begin to hold ${isBack ? "before" : "behind"} this time.`;
      return;
    }
    from_s = (isBack ? told.looked_from_ns : told.looked_to_ns) / 1e9;
    said.value = `Looked as far as ${timeText(from_s)} …`;
  }
}

function Controls() {
  const at = pastAt.value;
  const isPlaying = pace.value > 0;
  const play = () => {
    if (at === null) lookAt(Math.max(end_s.peek() - 10, 0));
    pace.value = isPlaying ? 0 : chosenPace.peek();
  };
  return (
    <div class="row time-line-controls" id="time-line-controls">
      <h2 class="out-of-sight">Time line</h2>
      <button type="button" aria-label="Event before" title="Event before" onClick={() => jump(true)}>
        ◂
      </button>
      <button type="button" onClick={play}>
        {isPlaying ? "Stop" : "Play"}
      </button>
      <button type="button" aria-label="Next event" title="Next event" onClick={() => jump(false)}>
        ▸
      </button>
      <label>
        <span class="out-of-sight">Pace</span>
        <select
          value={String(chosenPace.value)}
          onChange={(event) => {
            chosenPace.value = Number(event.currentTarget.value);
            if (isPlaying) pace.value = chosenPace.peek();
          }}
        >
          {PACES.map((each) => (
            <option key={each} value={String(each)}>
              {each}×
            </option>
          ))}
        </select>
      </label>
      <button type="button" aria-label="Zoom the time line in" onClick={() => zoom(0.5)}>
        +
      </button>
      <button type="button" aria-label="Zoom the time line out" onClick={() => zoom(2)}>
        −
      </button>
      <form
        class="row"
        onSubmit={(event) => {
          event.preventDefault();
          find(false);
        }}
      >
        <input
          type="search"
          class="mono"
          placeholder="abs(m1.e) > 5"
          aria-label="Condition to look for"
          value={condition.value}
          onInput={(event) => (condition.value = event.currentTarget.value)}
        />
        <button type="button" disabled={!condition.value.trim()} onClick={() => find(true)}>
          Last
        </button>
        <button type="submit" disabled={!condition.value.trim()}>
          Next
        </button>
      </form>
      {at !== null && <OpenHere at_s={at} />}
      <span class="push mono" role="status" aria-live="polite">
        {said.value}
      </span>
      <span class="mono">{at === null ? "live" : timeText(at)}</span>
      {trouble.value && <span class="problem">{trouble.value}</span>}
    </div>
  );
}

/** The command that makes a bench of its own of this time. */
function OpenHere({ at_s }: { at_s: number }) {
  const [isOpen, setOpen] = useState(false);
  const words = `hil replay ${hello.value?.bench ?? ""}/last --until ${at_s.toFixed(6)}s --serve`;
  return (
    <span class="open-here">
      <button type="button" aria-expanded={isOpen} onClick={() => setOpen(!isOpen)}>
        Open here as a bench
      </button>
      {isOpen && (
        <span class="row">
          <code>{words}</code>
          <button type="button" onClick={() => void navigator.clipboard?.writeText(words).catch(notifyError)}>
            Copy
          </button>
        </span>
      )}
    </span>
  );
}

function onKey(event: KeyboardEvent): void {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  const [from, to] = shown();
  const at = pastAt.peek() ?? end_s.peek();
  const step = ((to - from) / 200) * (event.shiftKey ? 10 : 1);
  const actions: Record<string, () => void> = {
    ArrowLeft: () => goTo(at - step),
    ArrowDown: () => goTo(at - step),
    ArrowRight: () => goTo(at + step),
    ArrowUp: () => goTo(at + step),
    PageUp: () => jump(true),
    PageDown: () => jump(false),
    Home: () => goTo(0),
    End: live,
    "+": () => zoom(0.5),
    "-": () => zoom(2),
  };
  const action = actions[event.key];
  if (!action) return;
  event.preventDefault();
  action();
}

function Line() {
  const place = useRef<HTMLCanvasElement>(null);
  const drawn = useRef<LineCanvas | null>(null);
  const [hovered, setHovered] = useState<PastMark | undefined>(undefined);
  useEffect(() => {
    if (!place.current) return;
    const made = new LineCanvas(place.current);
    drawn.current = made;
    return () => {
      drawn.current = null;
      made.end();
    };
  }, [theme.value]);
  const [from, to] = shown();
  const at = pastAt.value;
  useEffect(() => drawn.current?.show({ marks: marks.value, from_s: from, to_s: to, end_s: end_s.value, ready_s: ready_s.value, at_s: at }));
  const timeAt = (event: PointerEvent) => {
    const box = place.current!.getBoundingClientRect();
    return from + ((event.clientX - box.left) / box.width) * (to - from);
  };
  return (
    <div
      class="time-line-line"
      role="slider"
      tabIndex={0}
      aria-label="Time of the run that is shown"
      aria-valuemin={0}
      aria-valuemax={Math.round(end_s.value * 1000) / 1000}
      aria-valuenow={Math.round((at ?? end_s.value) * 1000) / 1000}
      aria-valuetext={at === null ? "live" : `${timeText(at)}, ${agoText(end_s.value - at)} ago`}
      onKeyDown={onKey}
      onPointerDown={(event) => {
        event.currentTarget.setPointerCapture(event.pointerId);
        pace.value = 0;
        lookAt(timeAt(event));
      }}
      onPointerMove={(event) => {
        if (event.buttons & 1) lookAt(timeAt(event));
        setHovered(drawn.current?.markAt(event.offsetX, event.offsetY));
      }}
      onPointerLeave={() => setHovered(undefined)}
      onWheel={(event) => event.ctrlKey && (event.preventDefault(), zoom(event.deltaY < 0 ? 0.8 : 1.25))}
    >
      <canvas ref={place} aria-hidden="true" />
      {hovered && <span class="time-line-hover card">{textOf(hovered)}</span>}
    </div>
  );
}
