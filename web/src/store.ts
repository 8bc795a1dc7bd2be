/** State of the page: the link and what every view looks at. Signals, so that each view redraws what it shows. */

import { computed, effect, signal } from "@preact/signals";
import { VERSION } from "./build";
import { flush, keptFor, notKept, rememberByTab, rememberedByTab, unsaved } from "./kept";
import type { ActiveFault, FaultMark } from "./model/fault_marks";
import { type RunProgress, readRun, withRun } from "./model/run_progress";
import { NO_STATUS, type Status } from "./model/status";
import { Link } from "./net/link";
import type { DeviceRow, Role } from "./model/door";

/** The server's version while it is another one than this page's, and somebody writes here. */
export const newVersion = signal("");
/** The same, although the page was loaded again. */
export const otherVersion = signal("");

/** For so long the time goes on without being told. */
const MOST_UNTOLD_s = 1;

const RELOADED_FOR = "hil.reloaded-for";
const LAST_BENCH = "hil.last-bench";

/** Load the page again where nobody writes in it. Once for a version of the server; a second time would not help. */
function versionDiffers(server: string): void {
  if (rememberedByTab(RELOADED_FOR) === server) otherVersion.value = server;
  else if (unsaved.peek().length > 0 || isTyped(document.activeElement)) newVersion.value = server;
  else loadVersion(server);
}

/** Load the page of a version of the server; what is typed is kept. */
export function loadVersion(server: string): void {
  flush();
  if (rememberByTab(RELOADED_FOR, server)) window.location.reload();
  else otherVersion.value = server; // a tab that remembers nothing would load itself again and again
}

function isTyped(focused: Element | null): boolean {
  if (focused instanceof HTMLElement && focused.isContentEditable) return true;
  return (focused instanceof HTMLInputElement || focused instanceof HTMLTextAreaElement) && focused.value !== "";
}

export const link = new Link(VERSION, versionDiffers);

export const hello = link.hello;

effect(() => {
  const bench = hello.value?.bench;
  if (bench === undefined) return;
  if (isAnother(bench)) window.location.reload();
  else keptFor.value = bench;
});

/** True where another bench has come to the address, and the page loses nothing when it begins as new: samples,
 * events and terminals of the one before are not of this one. */
function isAnother(bench: string): boolean {
  if (!keptFor.peek() || keptFor.peek() === bench) return false;
  flush();
  return (notKept.peek().size === 0 || unsaved.peek().length === 0) && rememberByTab(LAST_BENCH, bench);
}

/** Devices of the bench, each with its first axis, and further axes, by name. */
export const devices = computed<Map<string, DeviceRow>>(() => new Map((hello.value?.devices ?? []).map((device) => [device.name, device])));

const RANK: Record<Role, number> = { viewer: 1, operator: 2, admin: 3 };

/** Whether the page shows the past: nothing can be done there. */
export const isPast = signal(false);

/** Tell whether the user's role allows what needs `role`, and the page shows the present. */
export function may(role: Role): boolean {
  return !isPast.value && RANK[hello.value?.role ?? "viewer"] >= RANK[role];
}

/** Say why something cannot be done that needs a role. */
export function whyNot(role: Role): string {
  return isPast.value ? "What you see is past: nothing can be done there." : `This needs the role ${role}.`;
}

export const status = signal<Status>(NO_STATUS);
/** The status before the present one: rates are differences. */
export const statusBefore = signal<Status>(NO_STATUS);

export const activeFaults = signal<ActiveFault[]>([]);

export const faultMarks = signal<FaultMark[]>([]);

/** Runs that the bench remembers, the last first. */
export const runs = signal<RunProgress[]>([]);

export function takeProgress(run: RunProgress): void {
  runs.value = withRun(runs.peek(), run);
}

/** Ask for all runs that the bench remembers: those of before the page, and of others. */
export async function readRuns(): Promise<void> {
  const told = await link.ask("runs", "").catch(() => null);
  if (Array.isArray(told))
    runs.value = told
      .map(readRun)
      .filter((run) => run !== null)
      .reverse();
}

/** Time of this page at which the status was told, in ms. */
let toldAt_ms = 0;

export function takeStatus(told: Status): void {
  statusBefore.value = status.peek();
  toldAt_ms = performance.now();
  status.value = told;
}

/** Simulated time at the bench, in seconds, as last told. */
export function toldTime_s(): number {
  return (status.peek().sim_ns ?? 0) / 1e9;
}

/** Simulated time at the bench, in seconds: it is told twice a second, and goes on evenly between. */
export function benchTime_s(): number {
  if (link.state.peek() !== "open" || toldAt_ms === 0) return toldTime_s();
  const since_s = Math.min((performance.now() - toldAt_ms) / 1000, MOST_UNTOLD_s);
  return toldTime_s() + since_s * (status.peek().speed ?? 1);
}
