/** What a card says of an axis: its mode, set-point and following error, whether it moves, what is wrong. Pure. */

import type { DeviceRow } from "./door";
import type { ActiveFault, FaultMark } from "./fault_marks";
import type { DeviceStatus, Problem, Snapshot } from "./status";

export interface AxisCard {
  /** Address of the device, or of a further axis of one. */
  name: string;
  profile: string;
  state: "ok" | "failed" | "fault" | "unknown";
  /** State in a word or two, and why it is so. */
  stateText: string;
  why: string;
  /** Mode of its control law, or what it does: x, v, off, cruise. Empty: that is not told. */
  mode: string;
  setPoint: number | null;
  setPointUnit: string;
  /** How far the shaft is from where it should be; null: it does not tell. */
  error: number | null;
  errorUnit: string;
  moves: boolean;
  /** Fault of it that was last, with when; empty: there was none. */
  lastFault: string;
  clients: number;
  bytes_per_s: number;
}

const MOTION_STATES = ["standby", "accel", "cruise", "decel", "stop"];
/** Speed below which a shaft stands: above the noise of a measured speed. */
const TURNS_RPM = 5;
const SET_POINTS = ["to_be_deg", "commanded_deg"];

/** Snapshot of an axis in its device's status. */
export function snapshotOf(row: DeviceStatus | undefined, address: string): Snapshot | null {
  return row?.snapshots[address] ?? row?.snapshot ?? null;
}

/** Mode of an axis in a word, by the fields that its kind has; empty: none says it. */
export function modeOf(shot: Snapshot | null): string {
  if (!shot) return "";
  const at = (name: string) => numberIn(shot, name);
  const loop_on = at("loop_on");
  if (loop_on !== null) return !loop_on ? "off" : at("mode") ? String.fromCharCode(at("mode")!) : "on";
  const motion = at("motion_state");
  if (motion !== null) return MOTION_STATES[motion] ?? "";
  const enabled = at("is_enabled") ?? at("enabled");
  if (enabled !== null) return enabled ? "on" : "off";
  const outputs = at("outputs_on");
  return outputs === null ? "" : outputs ? `1/${at("microsteps") ?? 1} step` : "off";
}

/** Set-point with its unit; null: it has none now. That of a servo is an angle or a speed, by its mode. */
export function setPointOf(shot: Snapshot | null): { value: number; unit: string } | null {
  if (!shot) return null;
  const mode = modeOf(shot);
  const r = numberIn(shot, "r");
  if (r !== null && numberIn(shot, "loop_on") !== null) {
    if (mode === "off") return null;
    return { value: r, unit: mode === "v" ? "rpm" : mode === "t" ? "counts" : "deg" };
  }
  const name = SET_POINTS.find((each) => numberIn(shot, each) !== null);
  return name === undefined || mode === "off" ? null : { value: numberIn(shot, name)!, unit: "deg" };
}

/** Following error with its unit, in the coordinates of the board; null: it does not tell. */
export function errorOf(shot: Snapshot | null): { value: number; unit: string } | null {
  if (!shot) return null;
  const e = numberIn(shot, "e");
  const setPoint = setPointOf(shot);
  if (e !== null) return setPoint && setPoint.unit !== "counts" ? { value: e, unit: setPoint.unit } : null;
  const lag = numberIn(shot, "lag_steps");
  return lag === null ? null : { value: lag, unit: "steps" };
}

/** Whether a shaft turns, or its board is at it. */
export function movesIn(shot: Snapshot | null): boolean {
  if (!shot) return false;
  return (numberIn(shot, "motion_state") ?? 0) > 0 || Math.abs(numberIn(shot, "velocity_rpm") ?? 0) > TURNS_RPM;
}

/** What is known of an axis beside its status. */
export interface Beside {
  faults: readonly ActiveFault[];
  marks: readonly FaultMark[];
  problems: readonly Problem[];
  bytes_per_s: number;
  isOpen: boolean;
}

export function cardOf(device: Pick<DeviceRow, "name" | "profile">, row: DeviceStatus | undefined, beside: Beside): AxisCard {
  const owner = ownerOf(device.name);
  const shot = snapshotOf(row, device.name);
  const setPoint = setPointOf(shot);
  const error = errorOf(shot);
  const last = beside.marks.filter((mark) => ownerOf(mark.target) === owner).at(-1);
  return {
    name: device.name,
    profile: device.profile,
    ...stateOf(owner, row, beside),
    mode: modeOf(shot),
    setPoint: setPoint?.value ?? null,
    setPointUnit: setPoint?.unit ?? "",
    error: error?.value ?? null,
    errorUnit: error?.unit ?? "",
    moves: movesIn(shot),
    lastFault: last ? `${words(last.kind)}, ${last.end_s === null ? "since" : "at"} ${last.begin_s.toFixed(1)} s` : "",
    clients: row?.clients ?? 0,
    bytes_per_s: beside.bytes_per_s,
  };
}

function stateOf(owner: string, row: DeviceStatus | undefined, beside: Beside): Pick<AxisCard, "state" | "stateText" | "why"> {
  if (!row) return { state: "unknown", stateText: beside.isOpen ? "–" : "unknown", why: "" };
  if (row.failed) return { state: "failed", stateText: "failed", why: row.failed };
  const problem = beside.problems.find(({ about }) => ownerOf(about) === owner);
  if (problem) return { state: "failed", stateText: "trouble", why: `${problem.what}${problem.remedy ? `; ${problem.remedy}` : ""}` };
  const faults = beside.faults.filter((fault) => ownerOf(fault.target) === owner);
  if (!faults.length) return { state: "ok", stateText: "ok", why: row.note };
  const kinds = faults.map(({ kind }) => words(kind)).join(", ");
  return { state: "fault", stateText: faults.length > 1 ? `${faults.length} faults` : kinds, why: kinds };
}

const RANK: Record<AxisCard["state"], number> = { failed: 0, fault: 1, unknown: 2, ok: 3 };

/** Cards with trouble first, all else in the bench's order; those alone whose name or profile has the filter's text. */
export function inOrder(cards: readonly AxisCard[], filter: string): AxisCard[] {
  const wanted = filter.trim().toLowerCase();
  const shown = cards.filter(({ name, profile, stateText, mode }) => `${name} ${profile} ${stateText} ${mode}`.toLowerCase().includes(wanted));
  return shown
    .map((card, at) => ({ card, at }))
    .sort((a, b) => RANK[a.card.state] - RANK[b.card.state] || a.at - b.at)
    .map(({ card }) => card);
}

/** Share of a bar that an error fills: small errors show, too, and large ones fill it. */
export function errorShare(error: number): number {
  const most = 100;
  return Math.min(Math.log1p(Math.abs(error) * 10) / Math.log1p(most * 10), 1);
}

/** Name of a kind as words: shaft_jam, "shaft jam". */
export function words(kind: string): string {
  return kind.replaceAll("_", " ");
}

export function ownerOf(address: string): string {
  return address.split(".")[0] ?? address;
}

function numberIn(shot: Snapshot, name: string): number | null {
  const value = shot[name];
  return typeof value === "number" && Number.isFinite(value) ? value : null;
}
