/** Faults that are active, with what ends them. */

import { notifyError } from "../../parts/notices";
import { href } from "../../router";
import { activeFaults, hello, link, may } from "../../store";
import type { ActiveFault } from "../../model/fault_marks";
import { timingText } from "./fault_places";

const TIMING = ["start_s", "for_s", "every_s"];

export function ActiveFaults() {
  const faults = activeFaults.value;
  const clear = (number: number | "all") => link.ask("clear", "", { number }).catch(notifyError);
  return (
    <section class="card" aria-label="Active faults">
      <div class="card-head">
        <h2>Active faults</h2>
        <span class="soft">{faults.length || "none"}</span>
        <button type="button" class="push" disabled={!faults.length || !may("admin")} onClick={() => void clear("all")}>
          Clear all
        </button>
      </div>
      {faults.length > 0 && (
        <div class="scroll-x" tabIndex={0} role="region" aria-label="Table of active faults">
          <table>
            <thead>
              <tr>
                <th scope="col" class="num">
                  number
                </th>
                <th scope="col">fault</th>
                <th scope="col">on</th>
                <th scope="col">parameters</th>
                <th scope="col">when</th>
                <th scope="col">
                  <span class="out-of-sight">clear</span>
                </th>
              </tr>
            </thead>
            <tbody>
              {faults.map((fault) => (
                <Row key={fault.number} fault={fault} clear={() => void clear(fault.number)} />
              ))}
            </tbody>
          </table>
        </div>
      )}
    </section>
  );
}

function Row({ fault, clear }: { fault: ActiveFault; clear(): void }) {
  const kind = hello.value?.fault_kinds.find((each) => each.name === fault.kind);
  const since = fault.begin_s === null ? "" : `from ${fault.begin_s.toFixed(1)} s`;
  return (
    <tr>
      <td class="num">{fault.number}</td>
      <th scope="row">
        {kind?.title ?? fault.kind} <span class="mono soft">{fault.kind}</span>
      </th>
      <td class="place">
        <a href={href("faults", fault.target)}>{fault.target}</a>
      </td>
      <td class="mono soft">{parametersText(fault.parameters)}</td>
      <td class="soft">{[since, timingText(fault.parameters)].filter(Boolean).join(", ")}</td>
      <td>
        <button type="button" disabled={!may("admin")} aria-label={`Clear fault ${fault.number}, ${fault.kind} on ${fault.target}`} onClick={clear}>
          Clear
        </button>
      </td>
    </tr>
  );
}

function parametersText(parameters: Record<string, unknown>): string {
  return Object.entries(parameters)
    .filter(([name, value]) => !TIMING.includes(name) && !(name === "seed" && value === 0))
    .map(([name, value]) => `${name} ${String(value)}`)
    .join(", ");
}
