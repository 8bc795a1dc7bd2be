/** The companion of SACs: queue, one-shots, histories, calibration, by the terminal of a twin or a real board. */

import { useEffect } from "preact/hooks";
import { go } from "../../router";
import { hello, may } from "../../store";
import type { Hello } from "../../net/protocol";
import { boardSession, type BoardSession } from "./board_session";
import { ControlCard } from "./control_card";
import { OneShotCard } from "./oneshot_card";
import { QueueCard } from "./queue_card";
import { TimesCard, TrafficCard } from "./traffic_cards";
import "./companion.css";

const PROFILE = "sac";

/** Ports at which a SAC's terminal may be: the device's own first. */
function sacPorts(bench: Hello): string[] {
  const boards = bench.devices.filter(({ profile }) => profile === PROFILE).map(({ name }) => name);
  return boards.flatMap((name) => [name, ...bench.ports.filter((port) => port.startsWith(`${name}.`))]);
}

export function CompanionView({ path }: { path: string[] }) {
  const bench = hello.value;
  const ports = bench ? sacPorts(bench) : [];
  const port = ports.includes(path[0] ?? "") ? path[0]! : ports[0];
  if (!port) return <p class="empty">There is no SAC on this bench.</p>;
  if (!may("operator")) return <p class="empty">The companion types at boards: it needs the role operator.</p>;
  return (
    <>
      {path[0] !== undefined && path[0] !== port && (
        <p class="problem no-place">
          There is no SAC at “{path[0]}”. This is {port}.
        </p>
      )}
      <Companion key={port} port={port} ports={ports} />
    </>
  );
}

function Companion({ port, ports }: { port: string; ports: string[] }) {
  const session = boardSession(port);
  useEffect(() => {
    session.attach();
    return () => session.detach();
  }, [session]);
  const isDisabled = !session.isReady;
  return (
    <div class="companion">
      <div class="row companion-head">
        <label>
          Board{" "}
          <select value={port} onChange={(event) => go("companion", event.currentTarget.value)}>
            {ports.map((each) => (
              <option key={each}>{each}</option>
            ))}
          </select>
        </label>
        <BoardState session={session} />
      </div>
      <QueueCard session={session} isDisabled={isDisabled} />
      <div class="companion-side">
        <ControlCard session={session} isDisabled={isDisabled} />
        <TrafficCard session={session} isDisabled={isDisabled} />
      </div>
      <div class="companion-below">
        <OneShotCard session={session} isDisabled={isDisabled} />
        <TimesCard session={session} />
      </div>
    </div>
  );
}

const WORDS: Record<string, string> = {
  opening: "listening",
  starting: "starting",
  asking: "asking",
  ready: "at its prompt",
  silent: "no answer",
  closed: "closed",
};
const PILLS: Record<string, string> = { ready: "is-ok", silent: "is-bad", closed: "is-bad" };

function BoardState({ session }: { session: BoardSession }) {
  const { state, why } = session.state.value;
  const board = session.configuration.value;
  return (
    <div class="row" role="status">
      <span class={`pill ${PILLS[state] ?? "is-running"}`}>{WORDS[state]}</span>
      {why && <span class={state === "starting" ? "soft" : "problem"}>{why}</span>}
      {state === "silent" && (
        <button type="button" onClick={() => session.retry()}>
          Try again
        </button>
      )}
      {state === "ready" && board && (
        <span class="soft">
          {board.steps_per_rev} steps a turn, {2 ** board.microstep_exponent} pulses a step
          {board.is_network_swapped ? "; its network is at the USB port" : ""}
        </span>
      )}
    </div>
  );
}
