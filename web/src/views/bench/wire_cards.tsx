/** Cards of segments, CAN buses and doors. */

import type { DoorStatus, WireStatus } from "../../model/status";
import { href } from "../../router";
import { activeFaults, status } from "../../store";
import { BreakLink } from "./axis_card_view";

export function hasTrouble(wire: WireStatus): boolean {
  return reasonOf(wire) !== "" || faultsOn(wire.name).length > 0;
}

function reasonOf(wire: WireStatus): string {
  const problems = (status.value.health?.problems ?? []).filter(({ about }) => about === wire.name || about.startsWith(`${wire.name}.`));
  const nodes = wire.kind === "bus" ? wire.nodes.filter(({ isBad }) => isBad).map(({ name, state }) => `${name}: ${state}`) : [];
  return [...new Set([...problems.map(({ what }) => what), ...wire.notes, ...nodes])].join("; ");
}

function faultsOn(name: string): string[] {
  return activeFaults.value.filter(({ target }) => target === name || target.startsWith(`${name}.`)).map(({ kind }) => kind.replaceAll("_", " "));
}

export function WireCard({ wire }: { wire: WireStatus }) {
  const reason = reasonOf(wire);
  const faults = faultsOn(wire.name);
  const state = reason ? "failed" : faults.length ? "fault" : "ok";
  const isBus = wire.kind === "bus";
  return (
    <article class={`card wire-card is-${state}`} aria-label={wire.name}>
      <div class="device-head">
        <a class="device-name" href={href("wire", wire.name)}>
          {wire.name}
        </a>
        <span class="soft">{isBus ? "CAN bus" : "segment"}</span>
        <span class={`pill push is-${state}`}>{faults.length ? faults.join(", ") : state === "failed" ? "trouble" : "ok"}</span>
      </div>
      {reason && (
        <span class="card-why" title={reason}>
          {reason}
        </span>
      )}
      <div class="reading-line">
        <span>
          <span class="mono reading is-big">{wire.load_percent === null ? "–" : wire.load_percent.toFixed(1)}</span> % load
        </span>
        <span>
          <span class="mono reading">{wire.passed.toLocaleString("en")}</span> {isBus ? "frames" : "packets"}
        </span>
      </div>
      {(wire.collisions > 0 || wire.errors > 0) && (
        <p class="problem">
          {wire.collisions} collisions, {wire.errors} errors
        </p>
      )}
      <ul class="node-list" aria-label={`Nodes of ${wire.name}`}>
        {wire.nodes.map((node) => (
          <li key={node.name} class={node.isBad ? "is-bad" : ""}>
            <span>{node.name}</span>
            <span class="soft">{node.state}</span>
            <span class="mono">{node.counts}</span>
          </li>
        ))}
      </ul>
      <BreakLink name={wire.name} />
    </article>
  );
}

export function DoorCard({ door }: { door: DoorStatus }) {
  return (
    <article class="card door-card" aria-label={`Door ${door.name}`}>
      <div class="device-head">
        <strong>{door.name}</strong>
        <span class="soft">door</span>
        <span class={`pill push ${door.risk ? "is-late" : "is-ok"}`} title={door.risk}>
          {door.risk ? "open to all" : "ok"}
        </span>
      </div>
      <div class="reading-line">
        <span>
          <span class="mono reading is-big">{door.links}</span> connected
        </span>
      </div>
      <dl class="card-facts">
        <dt>address</dt>
        <dd class="mono" title={door.address}>
          {door.address}
        </dd>
        <dt>requests</dt>
        <dd class="mono">{door.commands.toLocaleString("en")}</dd>
        {door.rejected > 0 && (
          <>
            <dt>refused</dt>
            <dd class="mono">{door.rejected.toLocaleString("en")}</dd>
          </>
        )}
        {door.dropped > 0 && (
          <>
            <dt>dropped</dt>
            <dd class="mono">{door.dropped.toLocaleString("en")}</dd>
          </>
        )}
      </dl>
    </article>
  );
}
