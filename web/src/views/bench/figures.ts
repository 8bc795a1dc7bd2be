/** State, rate and lag of a device, from the bench's status. */

import type { DeviceStatus, Status } from "../../model/status";
import { activeFaults, devices, link, status, statusBefore } from "../../store";

export interface Figures {
  state: "ok" | "failed" | "fault" | "unknown";
  stateText: string;
  why: string;
  bytes_per_s: number;
  lag_ms: number | null;
  clients: number;
}

/** Collect the figures of a device or an axis, by its address. */
export function figuresOf(address: string): Figures {
  const name = address.split(".")[0] ?? address;
  const now = rowOf(status.value, name);
  const before = rowOf(statusBefore.value, name);
  const faults = activeFaults.value.filter((fault) => fault.target.split(".")[0] === name);
  const figures: Figures = {
    state: "ok",
    stateText: "ok",
    why: "",
    bytes_per_s: now && before ? rate_Hz(now, before) : 0,
    lag_ms: lag_ms(now, address),
    clients: now?.clients ?? 0,
  };
  if (!now) return { ...figures, state: "unknown", stateText: devices.value.has(name) && link.state.value === "open" ? "–" : "unknown" };
  if (now.failed) return { ...figures, state: "failed", stateText: "failed", why: now.failed };
  if (!faults.length) return { ...figures, why: now.note };
  const kinds = faults.map((fault) => fault.kind).join(", ");
  return { ...figures, state: "fault", stateText: faults.length > 1 ? `${faults.length} faults` : kinds, why: kinds };
}

function rowOf(told: Status, name: string): DeviceStatus | undefined {
  return told.devices.find((row) => row.device === name);
}

function rate_Hz(now: DeviceStatus, before: DeviceStatus): number {
  const seconds = ((status.value.elapsed_ns ?? 0) - (statusBefore.value.elapsed_ns ?? 0)) / 1e9;
  const bytes = now.rx_bytes + now.tx_bytes - before.rx_bytes - before.tx_bytes;
  return seconds > 0 && bytes > 0 ? bytes / seconds : 0;
}

/** How far an axis is behind the simulated time; null where it does not tell. */
function lag_ms(row: DeviceStatus | undefined, address: string): number | null {
  const shot = row?.snapshots?.[address] ?? row?.snapshot;
  const at_ns = shot?.["at_ns"];
  const sim_ns = status.value.sim_ns;
  if (typeof at_ns !== "number" || typeof sim_ns !== "number") return null;
  return Math.max(0, (sim_ns - at_ns) / 1e6);
}
