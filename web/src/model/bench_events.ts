/** What happened to the bench, as rows of a list: told by the bench, or said by this page. Pure. */

import type { Operations } from "./door";
import type { FaultMark } from "./fault_marks";
import type { PastMark } from "./past";

export type BenchEvent = Operations["events"]["answer"]["events"][number];

/** Kinds of rows: each that the bench has, and "page": what this page said. */
export type EventKind = BenchEvent["kind"] | "page";
const KINDS: Record<EventKind, true> = {
  verbs: true,
  typed: true,
  faults: true,
  motors: true,
  runs: true,
  refusals: true,
  clients: true,
  reloads: true,
  lateness: true,
  trouble: true,
  log: true,
  page: true,
};
export const EVENT_KINDS = Object.keys(KINDS) as EventKind[];

export interface EventRow {
  key: string;
  kind: EventKind;
  /** Simulated time, in s, and that of the last of those that it stands for. */
  at_s: number;
  to_s: number;
  /** Device, port or wire that it is of; empty: the bench. */
  of: string;
  who: string;
  text: string;
  count: number;
  /** Start of the bench that it is of; rows of an earlier one have times of their own. */
  instance: string;
}

export interface EventRows {
  /** The oldest first. */
  rows: readonly EventRow[];
  /** Number of rows that were left out, for lack of room. */
  leftOut: number;
}

export const NO_EVENTS: EventRows = { rows: [], leftOut: 0 };
export const MOST_ROWS = 2000;
/** So near to one another are what the bench tells of a refusal and what the page said of it. */
const SAME_s = 10;

/** Read an event; null: it is none. */
export function readEvent(raw: unknown, instance: string): EventRow | null {
  const { number, kind, at_ns, to_ns, of, who, text, count } = (raw ?? {}) as Record<string, unknown>;
  if (typeof number !== "number" || typeof at_ns !== "number" || typeof text !== "string") return null;
  const known = EVENT_KINDS.find((each) => each === kind);
  if (!known) return null;
  return {
    key: `${instance} ${number}`,
    kind: known,
    at_s: at_ns / 1e9,
    to_s: typeof to_ns === "number" ? to_ns / 1e9 : at_ns / 1e9,
    of: String(of ?? ""),
    who: String(who ?? ""),
    text,
    count: typeof count === "number" ? count : 1,
    instance,
  };
}

/** Rows with others that came: one of the same key takes its place, and what the page said of a refusal that the bench tells, too, goes. */
export function withRows(before: EventRows, came: readonly EventRow[], most = MOST_ROWS): EventRows {
  if (!came.length) return before;
  const rows = new Map(before.rows.map((row) => [row.key, row]));
  for (const row of came) {
    const all = [...rows.values()].slice(-50);
    if (row.kind === "refusals" && row.who === "this page") {
      if (all.some((each) => each.who !== "this page" && isSaidBy(row, each))) continue;
    } else if (row.kind === "refusals") {
      for (const each of all) if (each.who === "this page" && isSaidBy(each, row)) rows.delete(each.key);
    }
    rows.set(row.key, row);
  }
  const sorted = [...rows.values()].sort((a, b) => (a.instance === b.instance ? a.at_s - b.at_s : 0));
  const tooMany = Math.max(sorted.length - most, 0);
  return { rows: tooMany ? sorted.slice(tooMany) : sorted, leftOut: before.leftOut + tooMany };
}

/** Whether the page said of a refusal what the bench tells of it: "enable: the loop is on". */
function isSaidBy(page: EventRow, bench: EventRow): boolean {
  const why = bench.text.slice(bench.text.indexOf(": ") + 2).replace(/…$/, "");
  return bench.kind === "refusals" && page.text.startsWith(why) && Math.abs(page.at_s - bench.at_s) < SAME_s;
}

/** Rows of these kinds that have all words of a text, the newest first. */
export function filtered(rows: readonly EventRow[], hidden: readonly string[], text: string): EventRow[] {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  const fits = (row: EventRow) => {
    const all = `${row.kind} ${row.of} ${row.who} ${row.text}`.toLowerCase();
    return words.every((word) => all.includes(word));
  };
  return rows.filter((row) => !hidden.includes(row.kind) && fits(row)).reverse();
}

/** Number of rows of each kind. */
export function countsOf(rows: readonly EventRow[]): Record<EventKind, number> {
  const counts = Object.fromEntries(EVENT_KINDS.map((kind) => [kind, 0])) as Record<EventKind, number>;
  for (const { kind } of rows) counts[kind] += 1;
  return counts;
}

/** What a recording has from its events alone, a second later: refusals of doors, clients, reloads, health. */
const LIVE_ALONE: readonly EventKind[] = ["refusals", "clients", "reloads", "lateness", "trouble"];

/** Marks of the time line: those of the recording, and what it does not have, of this start of the bench. */
export function marksWith(recorded: readonly PastMark[], rows: readonly EventRow[], instance: string): PastMark[] {
  const here = rows.filter((row) => row.instance === instance && LIVE_ALONE.includes(row.kind) && row.who !== "this page");
  if (!here.length) return [...recorded];
  const known = new Set(here.map(({ kind, at_s }) => `${kind} ${at_s.toFixed(1)}`));
  const others = recorded.filter(({ lane, from_s }) => !known.has(`${lane} ${from_s.toFixed(1)}`));
  return [...others, ...here.map(({ kind, at_s, to_s, of, text, who }) => ({ lane: kind, from_s: at_s, to_s, of, text: wordsOf({ of, who, text }) }))];
}

/** Faults that were injected, as marks: of those that ended before the page came nothing else is known. */
export function marksBefore(rows: readonly EventRow[]): FaultMark[] {
  return rows
    .filter(({ kind, of }) => kind === "faults" && of !== "")
    .map(({ at_s, of, text }) => ({ number: 0, kind: text.split(" ")[0] ?? text, target: of, begin_s: at_s, end_s: at_s }));
}

/** An event in a line: "m1 enable (ann)". */
export function wordsOf({ of, who, text }: Pick<EventRow, "of" | "who" | "text">): string {
  const asker = who && who !== "bench" && who !== of ? ` (${who})` : "";
  return `${of && !text.startsWith(of) ? `${of}: ` : ""}${text}${asker}`;
}
