/** State of a CAN bus: load, errors, and each controller with its error counters. */

import { status } from "../../store";
import type { BusNodeStatus } from "../../model/bus_status";

export function BusState({ name }: { name: string }) {
  const bus = status.value.buses?.find((each) => each.bus === name);
  if (!bus) return null;
  const wrong = bus.errors.filter(([, count]) => count > 0).map(([error, count]) => `${error} ${count}`);
  return (
    <section class="card" aria-labelledby="bus-title">
      <h2 id="bus-title">Controllers</h2>
      <dl class="figures">
        <div>
          <dt>load since the start</dt>
          <dd class="mono">{bus.load_percent.toFixed(2)} %</dd>
        </div>
        <div>
          <dt>frames</dt>
          <dd class="mono">{bus.frames}</dd>
        </div>
        <div>
          <dt>error frames</dt>
          <dd class={wrong.length ? "mono problem" : "mono"}>{wrong.join(", ") || "none"}</dd>
        </div>
      </dl>
      <div class="scroll-x" tabIndex={0} role="region" aria-label="Table of controllers">
        <table>
          <caption class="out-of-sight">Controllers on the bus, with their error counters</caption>
          <thead>
            <tr>
              <th scope="col">Controller</th>
              <th scope="col">State</th>
              <th scope="col">CANopen</th>
              {["TEC", "REC", "Sent", "Heard"].map((title) => (
                <th key={title} scope="col" class="num" title={{ TEC: "transmit error counter", REC: "receive error counter" }[title]}>
                  {title}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {bus.nodes.map((node) => (
              <Controller key={node.node} node={node} drive={bus.drives.get(node.node)} />
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}

/** Value from which on an error counter makes a controller error-passive. */
const PASSIVE = 128;

function Controller({ node, drive }: { node: BusNodeStatus; drive: { id: number; state: string } | undefined }) {
  const look = node.state === "off" ? "soft" : node.state === "error-active" ? "" : "problem";
  const counter = (value: number) => <td class={value >= PASSIVE ? "num problem" : "num"}>{value}</td>;
  return (
    <tr>
      <th scope="row">{node.node}</th>
      <td class={look}>{node.state}</td>
      <td>{drive ? `node ${drive.id}, ${drive.state}` : ""}</td>
      {counter(node.transmit_errors)}
      {counter(node.receive_errors)}
      <td class="num">{node.sent}</td>
      <td class="num">{node.heard}</td>
    </tr>
  );
}
