/** State of the page: the link and what every view looks at. Signals, so that each view redraws what it shows. */

import { computed, signal } from "@preact/signals";
import { VERSION } from "./build";
import type { ActiveFault, FaultMark } from "./model/fault_marks";
import { Link } from "./net/link";
import type { DeviceRow, Role } from "./net/protocol";

/** The server's version while it is another one than this page's, although the page was loaded again. */
export const otherVersion = signal("");

const RELOADED_FOR = "hil.reloaded-for";

/** Load the page again, once for a version of the server; a second time would not help. */
function loadAgain(server: string): void {
  if (sessionStorage.getItem(RELOADED_FOR) === server) {
    otherVersion.value = server;
    return;
  }
  sessionStorage.setItem(RELOADED_FOR, server);
  window.location.reload();
}

export const link = new Link(VERSION, loadAgain);

export const hello = link.hello;

/** Devices of the bench, each with its first axis, and further axes, by name. */
export const devices = computed<Map<string, DeviceRow>>(
  () => new Map((hello.value?.devices ?? []).map((device) => [device.name, device])),
);

const RANK: Record<Role, number> = { viewer: 1, operator: 2, admin: 3 };

/** Tell whether the user's role allows what needs `role`. */
export function may(role: Role): boolean {
  return RANK[hello.value?.role ?? "viewer"] >= RANK[role];
}

/** Answer of the operation `status`; what is not there is undefined. */
export interface Status {
  sim_ns?: number;
  elapsed_ns?: number;
  rate_hz?: number;
  speed?: number;
  ticks?: number;
  missed?: number;
  rt?: string;
  rt_line?: string;
  health?: { state: string; late_ms: number; problems: unknown[] };
  devices?: DeviceStatus[];
}

export interface DeviceStatus {
  device: string;
  failed: string | null;
  clients: number;
  rx_bytes: number;
  tx_bytes: number;
  dropped_bytes: number;
  note?: string | null;
  address?: string;
  snapshot?: Record<string, number | null> | null;
  snapshots?: Record<string, Record<string, number | null>>;
}

export const status = signal<Status>({});
/** The status before the present one: rates are differences. */
export const statusBefore = signal<Status>({});

export const activeFaults = signal<ActiveFault[]>([]);

export const faultMarks = signal<FaultMark[]>([]);

export interface RunProgress {
  run: string;
  state: string;
  [key: string]: unknown;
}

export const runs = signal<RunProgress[]>([]);

/** Simulated time at the bench, in seconds, as last told. */
export function benchTime_s(): number {
  return (status.peek().sim_ns ?? 0) / 1e9;
}
