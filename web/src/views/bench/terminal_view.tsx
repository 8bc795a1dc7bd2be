/** A terminal at a port: what is said there in several views, search, macros, and a line to type. */

import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { keptTexts, ownOf } from "../../kept";
import { savedText, VIEWS, type ViewName } from "../../model/terminal_views";
import { saveFile } from "../../parts/files";
import { devices } from "../../store";
import { fileName } from "./export";
import { SendLine } from "./terminal_line";
import { Macros } from "./terminal_macros";
import { NumberPlot, numbersOf } from "./terminal_plot";
import { type TerminalPort, terminalPort } from "./terminal_port";
import { TerminalScreen } from "./terminal_screen";
import "./terminal.css";

/** View of each place with a terminal. */
const views = keptTexts("terminal.views");
const searches = keptTexts("terminal.searches");

export interface TerminalProps {
  port: string;
  /** Tells terminals at one port apart, whose views are kept. */
  place?: string;
  /** What else stands in its head. */
  children?: ComponentChildren;
}

export function TerminalView({ port: name, place = "", children }: TerminalProps) {
  const port = terminalPort(name);
  const key = `${name} ${place}`;
  const view: ViewName = views.value[key] !== undefined && views.value[key] in VIEWS ? (views.value[key] as ViewName) : "text";
  const screen = useRef<TerminalScreen | null>(null);
  const profile = devices.value.get(name.split(".")[0] ?? name)?.profile ?? "";
  const isOpen = port.isOpen.value;
  return (
    <div class="terminal" role="group" aria-label={`Terminal at ${name}`}>
      <div class="row terminal-head">
        <button type="button" onClick={() => (isOpen ? port.close() : port.open())}>
          {isOpen ? "Close the port" : "Open the port"}
        </button>
        <label>
          <span class="out-of-sight">View</span>
          <select value={view} onChange={(event) => (views.value = { ...views.peek(), [key]: event.currentTarget.value })}>
            {Object.entries(VIEWS).map(([each, title]) => (
              <option key={each} value={each}>
                {title}
              </option>
            ))}
          </select>
        </label>
        {view !== "plot" && <Find place={key} find={(text, isBack) => screen.current?.find(text, isBack)} />}
        <button type="button" title="Save what is kept of it, as it is shown" onClick={() => save(port, view)}>
          Save
        </button>
        <button type="button" onClick={() => port.clear()}>
          Clear
        </button>
        {children}
        <p class="soft terminal-note" role="status">
          {name}: {port.note.value}
          {port.typed.value && ` · ${port.typed.value}`}
        </p>
      </div>
      {view === "plot" ? <NumberPlot key={name} port={port} /> : <Screen key={`${name} ${view}`} port={port} view={view} screen={screen} />}
      <Typing port={port} />
      <div class="terminal-foot">
        <SendLine key={name} port={port} profile={profile} />
        <Macros port={port} profile={profile} />
      </div>
    </div>
  );
}

interface ScreenProps {
  port: TerminalPort;
  view: ViewName;
  screen: { current: TerminalScreen | null };
}

function Screen({ port, view, screen }: ScreenProps) {
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (!place.current) return;
    const made = new TerminalScreen(port, place.current, view);
    screen.current = made;
    return () => {
      made.end();
      screen.current = null;
    };
  }, [port, view]);
  return <div class="terminal-place" title="Keys go to the board; Ctrl-] leaves it for the keyboard" ref={place} />;
}

/** A long text that is being typed, as far as the board has taken it. */
function Typing({ port }: { port: TerminalPort }) {
  const typing = port.typing.value;
  if (!typing) return null;
  return (
    <div class="row terminal-typing">
      <progress max={typing.of} value={typing.taken} aria-label={`Typing at ${port.port}`} />
      <span class="mono soft">
        {typing.taken} of {typing.of} bytes typed
      </span>
      <button type="button" onClick={() => port.stopTyping()}>
        Stop typing
      </button>
    </div>
  );
}

interface FindProps {
  place: string;
  find(text: string, isBack: boolean): Promise<boolean> | undefined;
}

function Find({ place, find }: FindProps) {
  const text = ownOf(searches.value, place) ?? "";
  const setText = (to: string) => (searches.value = { ...searches.peek(), [place]: to });
  const [isMissing, setMissing] = useState(false);
  const search = async (isBack: boolean) => {
    const found = text ? await find(text, isBack) : true;
    setMissing(found === false);
  };
  return (
    <span class="terminal-find">
      <input
        type="search"
        placeholder="search"
        aria-label="Search; Enter finds the last one before, Shift and Enter the next"
        aria-invalid={isMissing}
        value={text}
        onInput={(event) => {
          setText(event.currentTarget.value);
          setMissing(false);
        }}
        onKeyDown={(event) => event.key === "Enter" && void search(!event.shiftKey)}
      />
      {isMissing && (
        <span class="problem" role="alert">
          not found
        </span>
      )}
    </span>
  );
}

const ENDS: Record<ViewName, string> = { text: "txt", times: "times.txt", hex: "hex.txt", plot: "csv" };

function save(port: TerminalPort, view: ViewName): void {
  const text = view === "plot" ? numbersOf(port).csv() : savedText(view, port.record.pieces, port.record.gone);
  saveFile(fileName(port.port, ENDS[view]), new TextEncoder().encode(text), view === "plot" ? "text/csv" : "text/plain");
}
