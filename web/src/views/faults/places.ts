/** Places where a kind of fault can be: those of the bench that look right. The bench itself decides. Pure. */

import type { FaultKindRow } from "../../model/door";
import type { Hello } from "../../net/protocol";

/** List the addresses for a kind's target, the likely ones. Empty: any address may be typed. */
export function placesOf(kind: FaultKindRow, bench: Hello): string[] {
  const twins = bench.devices.filter((device) => !device.is_real);
  const names = twins.map((device) => device.name);
  const withField = (field: string) => twins.filter((device) => device.fields.some((each) => each.name === field)).map((device) => device.name);
  const inSegments = bench.ports.filter((port) => !names.includes(port));
  const table: Record<string, string[]> = {
    device: names.filter((name) => bench.ports.includes(name) || !name.includes(".")),
    port: bench.ports,
    twin_port: bench.ports,
    station: [...inSegments, ...bench.ports],
    segment: bench.segments,
    line: [...bench.segments, ...bench.buses],
    on_line: [...inSegments, ...bench.ports],
    servo: withField("raw"),
    shaft: withField("position_deg"),
    supplied: withField("position_deg"),
  };
  return [...new Set(table[kind.target] ?? [...bench.ports, ...names, ...bench.segments, ...bench.buses])];
}
