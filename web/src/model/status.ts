/** The bench's status as the page uses it, read from what the door tells. Pure. */

import { type BusStatus, readBuses } from "./bus_status";

export interface DeviceStatus {
  device: string;
  failed: string | null;
  clients: number;
  rx_bytes: number;
  tx_bytes: number;
  note: string;
  /** What may be typed at it to be answered at once; empty: that is not known. */
  greeting: string;
  snapshot: Snapshot | null;
  snapshots: Record<string, Snapshot>;
}

export type Snapshot = Record<string, unknown>;

export interface Health {
  state: string;
  late_ms: number;
  problems: Problem[];
}

export interface Lease {
  user: string;
  why: string;
  until_wall_ns: number;
}

/** Problem of the bench. `about`: the device, port or wire; empty: the whole bench. */
export interface Problem {
  about: string;
  what: string;
  remedy: string;
}

/** Segment or CAN bus. `load_percent`: of its time, null where that is not told. */
export interface WireStatus {
  name: string;
  kind: "segment" | "bus";
  load_percent: number | null;
  passed: number;
  collisions: number;
  errors: number;
  nodes: WireNode[];
  notes: string[];
}

/** Station of a segment or node of a bus. `state`: of a CAN controller and its CANopen node; `counts`: in words. */
export interface WireNode {
  name: string;
  state: string;
  isBad: boolean;
  counts: string;
}

/** Door to other programs. */
export interface DoorStatus {
  name: string;
  address: string;
  links: number;
  commands: number;
  rejected: number;
  dropped: number;
  risk: string;
  /** True if it joins other benches by a router. */
  isJoined: boolean;
}

/** What is not told is undefined. */
export interface Status {
  sim_ns?: number;
  elapsed_ns?: number;
  speed?: number;
  health?: Health;
  /** Who has the bench for now; undefined: nobody. */
  lease?: Lease;
  /** Digest of the bench's drawing; empty: it has none. */
  drawing?: string;
  devices: DeviceStatus[];
  buses?: BusStatus[];
  wires: WireStatus[];
  doors: DoorStatus[];
}

/** Status of a bench that has told nothing yet. */
export const NO_STATUS: Status = { devices: [], wires: [], doors: [] };

/** Read the answer of the operation `status`; what has another form than it should is left out. */
export function readStatus(raw: unknown): Status {
  const told = object(raw);
  const status: Status = {
    devices: list(told["devices"])
      .map(readDevice)
      .filter((row) => row !== null),
    wires: [...list(told["segments"]).map(readSegment), ...list(told["buses"]).map(readBus)].filter((wire) => wire.name),
    doors: Object.entries(object(told["bridges"])).map(([name, row]) => readDoor(name, object(row))),
  };
  for (const name of ["sim_ns", "elapsed_ns", "speed"] as const) {
    const value = told[name];
    if (typeof value === "number" && Number.isFinite(value)) status[name] = value;
  }
  if ("drawing" in told) status.drawing = typeof told["drawing"] === "string" ? told["drawing"] : "";
  if ("buses" in told) status.buses = readBuses(told["buses"]);
  const lease = object(told["lease"]);
  if (typeof lease["user"] === "string") {
    status.lease = { user: lease["user"], why: string(lease["why"]), until_wall_ns: number(lease["until_wall_ns"]) };
  }
  const health = object(told["health"]);
  if (typeof health["state"] === "string") {
    status.health = { state: health["state"], late_ms: number(health["late_ms"]), problems: list(health["problems"]).map(readProblem) };
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
    note: string(row["note"]),
    greeting: string(row["greeting"]),
    snapshot: isObject(row["snapshot"]) ? row["snapshot"] : null,
    snapshots: Object.fromEntries(snapshots),
  };
}

function readProblem(raw: unknown): Problem {
  const { about, what, remedy } = object(raw);
  const text = typeof what === "string" ? what : typeof raw === "string" ? raw : JSON.stringify(raw);
  return { about: string(about), what: text, remedy: string(remedy) };
}

/** Say a problem with its place and remedy: "bus0: two stations have one address 85; give each an address". */
export function problemText(problem: Problem): string {
  return `${reasonText(problem)}${problem.remedy ? `; ${problem.remedy}` : ""}`;
}

/** A problem without what mends it: "m1: stopped: ...". */
export function reasonText({ about, what }: Pick<Problem, "about" | "what">): string {
  return `${about ? `${about}: ` : ""}${what}`;
}

function readSegment(raw: unknown): WireStatus {
  const row = object(raw);
  const stations = Object.entries(object(row["stations"])).map(([name, each]) => {
    const counts = object(each);
    return { name, state: "", isBad: number(counts["collisions"]) > 0, counts: `${number(counts["bursts"])} bursts` };
  });
  const nodes = Object.entries(object(row["nodes"])).map(([name, each]) => {
    const counts = object(each);
    const refusal = string(counts["refusal"]);
    const said = `${number(counts["requests"])} requests, ${number(counts["answers"])} answers`;
    return { name, state: `unit ${number(counts["unit"])}`, isBad: refusal !== "", counts: refusal || said };
  });
  return {
    name: string(row["segment"]),
    kind: "segment",
    load_percent: typeof row["load"] === "number" ? row["load"] * 100 : null,
    passed: number(row["packets"]),
    collisions: number(row["collisions"]),
    errors: sum(row["errors"]),
    nodes: nodes.length ? nodes : stations,
    notes: list(row["notes"]).map(string),
  };
}

function readBus(raw: unknown): WireStatus {
  const row = object(raw);
  const drives = object(row["drives"]);
  const nodes = Object.entries(object(row["nodes"])).map(([name, each]) => {
    const node = object(each);
    const drive = object(drives[name]);
    const states = [string(node["state"]), string(drive["state"])].filter((state) => state && state !== "error-active");
    const counts = `TEC ${number(node["transmit_errors"])} REC ${number(node["receive_errors"])}`;
    return { name, state: states.join(", ") || "error-active", isBad: string(node["state"]) !== "error-active", counts };
  });
  return {
    name: string(row["bus"]),
    kind: "bus",
    load_percent: typeof row["load_percent"] === "number" ? row["load_percent"] : null,
    passed: number(row["frames"]),
    collisions: 0,
    errors: sum(row["errors"]),
    nodes,
    notes: list(row["notes"]).map(string),
  };
}

function readDoor(name: string, row: Record<string, unknown>): DoorStatus {
  return {
    name,
    address: string(row["root"]) || string(list(row["listen"])[0]),
    links: number(row["links"]),
    commands: number(row["commands"]),
    rejected: number(row["rejected"]),
    dropped: number(row["dropped"]),
    risk: string(row["risk"]),
    isJoined: list(row["connect"]).length > 0,
  };
}

function sum(counters: unknown): number {
  return Object.values(object(counters)).reduce<number>((all, each) => all + number(each), 0);
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

function string(value: unknown): string {
  return typeof value === "string" ? value : "";
}

function number(value: unknown): number {
  return typeof value === "number" && Number.isFinite(value) ? value : 0;
}
