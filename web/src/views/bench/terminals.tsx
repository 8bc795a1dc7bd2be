/** Terminals at the ports of a device. */

import { useEffect, useRef, useState } from "preact/hooks";
import { may } from "../../store";
import { sessionOf, type TerminalSession } from "./terminal_session";

export function Terminals({ ports }: { ports: string[] }) {
  const [chosen, setChosen] = useState(ports[0] ?? "");
  const port = ports.includes(chosen) ? chosen : (ports[0] ?? "");
  if (!may("operator")) return <p class="soft">A terminal needs the role operator.</p>;
  return (
    <>
      {ports.length > 1 && (
        <div class="row" role="group" aria-label="Ports">
          {ports.map((each) => (
            <button key={each} type="button" aria-pressed={each === port} onClick={() => setChosen(each)}>
              {each}
            </button>
          ))}
        </div>
      )}
      <TerminalView key={port} session={sessionOf(port)} />
    </>
  );
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
