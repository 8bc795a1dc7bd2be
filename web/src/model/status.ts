/** The bench's status as the page uses it, read from what the door tells. Pure. */

import { type BusStatus, readBuses } from "./bus_status";

export interface DeviceStatus {
  device: string;
  failed: string | null;
  clients: number;
  rx_bytes: number;
  tx_bytes: number;
  note: string;
  snapshot: Snapshot | null;
  snapshots: Record<string, Snapshot>;
}

type Snapshot = Record<string, unknown>;

export interface Health {
  state: string;
  late_ms: number;
  problems: string[];
}

/** What is not told is undefined. */
export interface Status {
  sim_ns?: number;
  elapsed_ns?: number;
  speed?: number;
  health?: Health;
  /** Digest of the bench's drawing; empty: it has none. */
  drawing?: string;
  devices: DeviceStatus[];
  buses?: BusStatus[];
}

/** Read the answer of the operation `status`; what has another form than it should is left out. */
export function readStatus(raw: unknown): Status {
  const told = object(raw);
  const status: Status = {
    devices: list(told["devices"])
      .map(readDevice)
      .filter((row) => row !== null),
  };
  for (const name of ["sim_ns", "elapsed_ns", "speed"] as const) {
    const value = told[name];
    if (typeof value === "number" && Number.isFinite(value)) status[name] = value;
  }
  if ("drawing" in told) status.drawing = typeof told["drawing"] === "string" ? told["drawing"] : "";
  if ("buses" in told) status.buses = readBuses(told["buses"]);
  const health = object(told["health"]);
  if (typeof health["state"] === "string") {
    status.health = { state: health["state"], late_ms: number(health["late_ms"]), problems: list(health["problems"]).map(problemText) };
  }
  return status;
}

function readDevice(raw: unknown): DeviceStatus | null {
  const row = object(raw);
  if (typeof row["device"] !== "string") return null;
  const snapshots = Object.entries(object(row["snapshots"])).filter((each): each is [string, Snapshot] => isObject(each[1]));
  return {
    device: row["device"],
    failed: typeof row["failed"] === "string" ? row["failed"] : null,
    clients: number(row["clients"]),
    rx_bytes: number(row["rx_bytes"]),
    tx_bytes: number(row["tx_bytes"]),
    note: typeof row["note"] === "string" ? row["note"] : "",
    snapshot: isObject(row["snapshot"]) ? row["snapshot"] : null,
    snapshots: Object.fromEntries(snapshots),
  };
}

/** Say a problem with its place and remedy: "bus0: two stations have one address 85; give each an address". */
function problemText(raw: unknown): string {
  const { about, what, remedy } = object(raw);
  if (typeof what !== "string") return typeof raw === "string" ? raw : JSON.stringify(raw);
  const place = typeof about === "string" && about ? `${about}: ` : "";
  return `${place}${what}${typeof remedy === "string" && remedy ? `; ${remedy}` : ""}`;
}

function isObject(value: unknown): value is Record<string, unknown> {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function object(value: unknown): Record<string, unknown> {
  return isObject(value) ? value : {};
}

function list(value: unknown): unknown[] {
  return Array.isArray(value) ? (value as unknown[]) : [];
}

function number(value: unknown): number {
  return typeof value === "number" && Number.isFinite(value) ? value : 0;
}
