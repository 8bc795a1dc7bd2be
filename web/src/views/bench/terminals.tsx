/** Terminals at the ports of a device. */

import { signal } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { pastAt } from "../../past";
import { may } from "../../store";
import { PastTerminal } from "./past_terminal";
import type { TerminalSession } from "./terminal_session";

/** The terminal's own code: half of the page's, and loaded when somebody opens one. */
const code = signal<typeof import("./terminal_session") | null>(null);
const whyNoCode = signal("");

async function loadCode(): Promise<void> {
  whyNoCode.value = "";
  try {
    code.value = await import("./terminal_session");
  } catch {
    whyNoCode.value = "The terminal could not be loaded: load the page again.";
  }
}

export function Terminals({ ports }: { ports: string[] }) {
  const [chosen, setChosen] = useState(ports[0] ?? "");
  const port = ports.includes(chosen) ? chosen : (ports[0] ?? "");
  if (pastAt.value !== null) return <PastTerminals ports={ports} port={port} choose={setChosen} />;
  if (!may("operator")) return <p class="soft">A terminal needs the role operator.</p>;
  return (
    <>
      <Ports ports={ports} port={port} choose={setChosen} />
      <LoadedTerminal port={port} />
    </>
  );
}

interface PortsProps {
  ports: string[];
  port: string;
  choose: (port: string) => void;
}

function Ports({ ports, port, choose }: PortsProps) {
  if (ports.length < 2) return null;
  return (
    <div class="row" role="group" aria-label="Ports">
      {ports.map((each) => (
        <button key={each} type="button" aria-pressed={each === port} onClick={() => choose(each)}>
          {each}
        </button>
      ))}
    </div>
  );
}

function PastTerminals(given: PortsProps) {
  return (
    <>
      <Ports {...given} />
      <PastTerminal key={given.port} port={given.port} />
    </>
  );
}

function LoadedTerminal({ port }: { port: string }) {
  useEffect(() => void (code.peek() ?? loadCode()), []);
  if (code.value) return <TerminalView key={port} session={code.value.sessionOf(port)} />;
  return <p class={whyNoCode.value ? "problem" : "soft"}>{whyNoCode.value || "The terminal is loaded …"}</p>;
}

function TerminalView({ session }: { session: TerminalSession }) {
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => (place.current ? session.show(place.current) : undefined), [session]);
  const isOpen = session.isOpen.value;
  return (
    <div class="terminal" role="group" aria-label={`Terminal at ${session.port}`}>
      <div class="row">
        <button type="button" onClick={() => (isOpen ? session.close() : session.open())}>
          {isOpen ? "Close the port" : "Open the port"}
        </button>
        <button type="button" onClick={() => session.clear()}>
          Clear
        </button>
        <span class="soft" role="status">
          {session.port}: {session.note.value}
        </span>
      </div>
      <div class="terminal-place" ref={place} />
      <p class="soft">A client as any other: what you type goes to the board. Ctrl-] leaves it for the keyboard.</p>
    </div>
  );
}
