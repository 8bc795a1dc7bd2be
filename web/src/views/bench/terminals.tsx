/** Terminals at the ports of a device: one, or two below each other. */

import { keptText, keptTexts } from "../../kept";
import { pastAt } from "../../past";
import { Terminal } from "./terminal";

/** Port of each place, by device. */
const chosen = keptTexts("bench.terminals");
const split = keptText("bench.terminals.split");
/** Whether terminals have the plots' room, too. */
const wide = keptText("bench.terminals.wide");

export function areWide(): boolean {
  return wide.value === "yes" && pastAt.value === null;
}

export function Terminals({ ports, hasPlots }: { ports: string[]; hasPlots: boolean }) {
  const isSplit = split.value === "yes" && pastAt.value === null;
  return (
    <div class={isSplit ? "terminals is-split" : "terminals"}>
      <Place ports={ports} place="1" usual={ports[0] ?? ""}>
        <button
          type="button"
          aria-pressed={isSplit}
          title="Two terminals, each with its port and its view"
          onClick={() => (split.value = isSplit ? "" : "yes")}
        >
          Split
        </button>
        {hasPlots && (
          <button type="button" aria-pressed={areWide()} title="Without the plots" onClick={() => (wide.value = areWide() ? "" : "yes")}>
            Wide
          </button>
        )}
      </Place>
      {isSplit && <Place ports={ports} place="2" usual={ports[1] ?? ports[0] ?? ""} />}
    </div>
  );
}

interface PlaceProps {
  ports: string[];
  place: string;
  usual: string;
  children?: preact.ComponentChildren;
}

function Place({ ports, place, usual, children }: PlaceProps) {
  const key = `${ports[0]} ${place}`;
  const port = ports.find((each) => each === chosen.value[key]) ?? usual;
  return (
    <section class="terminal-half" aria-label={`Terminal ${place}`}>
      {ports.length > 1 && (
        <div class="row" role="group" aria-label="Ports">
          {ports.map((each) => (
            <button key={each} type="button" aria-pressed={each === port} onClick={() => (chosen.value = { ...chosen.peek(), [key]: each })}>
              {each}
            </button>
          ))}
        </div>
      )}
      <Terminal port={port} place={place}>
        {children}
      </Terminal>
    </section>
  );
}
