/** The layout that is shown, where it came from, and those that are saved. It is kept by the bench's name. */

import { computed, signal } from "@preact/signals";
import { Kept, KeptTogether } from "../kept";
import { emptyLayout, type Layout, MOST_PANELS, type PanelRow, panelsOf, readLayout, Unreadable } from "../model/layout";
import { isAlike, isFull, numbered, withPanel } from "../model/layout_change";
import { isLayoutText, layoutOfText, textOfLayout } from "../model/layout_text";
import { notify } from "../parts/notices";
import { href } from "../router";
import { hello } from "../store";
import { readyLayout, readyOnes } from "./ready";

/** What can be done with panels where they are shown: by the docking library, or in a stack. */
export interface Arranger {
  add(row: PanelRow): void;
  close(id: string): void;
  /** Bring a panel into sight, with the focus. */
  show(id: string): void;
}

interface Current {
  /** Address of the layout as it was opened, behind "layout". */
  from: string[];
  /** The same, as it was opened: what is shown may have changed since. */
  opened: Layout;
  layout: Layout;
}

function read(raw: unknown): Layout | undefined {
  try {
    return numbered(readLayout(raw));
  } catch {
    return undefined;
  }
}

function readCurrent(raw: unknown): Current | null | undefined {
  const { from, opened, layout } = (raw ?? {}) as Partial<Current>;
  const [was, is] = [read(opened), read(layout)];
  const isAddress = Array.isArray(from) && from.every((each) => typeof each === "string");
  return was && is && isAddress ? { from, opened: was, layout: is } : undefined;
}

function readAll(raw: unknown): Layout[] | undefined {
  return Array.isArray(raw) ? raw.flatMap((each) => read(each) ?? []).slice(0, MOST_SAVED) : undefined;
}

const MOST_SAVED = 50;
const MOST_RECENT = 5;

const current = new Kept<Current | null>("layout.current", () => null, readCurrent);
/** Layouts with names. */
export const saved = new KeptTogether<Layout[]>("layout.saved", () => [], readAll);
/** Layouts that were changed and not saved when another was opened, the newest first. */
export const recent = new Kept<Layout[]>("layout.recent", () => [], readAll);

/** Why an address was not opened, in words; empty: it was. */
export const trouble = signal("");
/** Grows when another layout is opened: what shows panels begins anew. */
export const openings = signal(0);
/** Panel whose settings are open. */
export const settingsOf = signal("");

export let arranger: Arranger | null = null;

export function setArranger(next: Arranger | null): void {
  arranger = next;
}

export const layout = computed<Layout>(() => current.value?.layout ?? emptyLayout(hello.value?.bench ?? ""));
export const isChanged = computed(() => {
  const now = current.value;
  return now !== null && !isAlike(now.opened, now.layout);
});
/** Panels that are shown, by id. */
const rows = computed(() => new Map(panelsOf(layout.value.root).map((row) => [row.id, row])));

export function rowOf(id: string): PanelRow | undefined {
  return rows.value.get(id) ?? coming.get(id);
}

/** Panels that were added, and are not yet in the layout. */
const coming = new Map<string, PanelRow>();

// ---- opening ----

let attempt = 0;
/** Bench whose layout is shown. */
let shownFor: string | undefined;

/** Open what an address names; without a name what was shown last. */
export async function openAddress(address: string[]): Promise<void> {
  const mine = ++attempt;
  trouble.value = "";
  try {
    const found = await find(address);
    if (mine !== attempt) return;
    if (found) open(found, address);
    else openLast();
  } catch (error) {
    if (mine !== attempt) return;
    openLast();
    trouble.value = error instanceof Unreadable ? error.message : String(error);
  }
}

/** Layout of an address; null: it names none. Throws Unreadable. */
async function find(address: string[]): Promise<Layout | null> {
  const [first = "", name = "", of = ""] = address;
  const bench = hello.peek();
  if (!first || !bench) return null;
  if (isLayoutText(first)) return layoutOfText(first);
  if (first === "ready") {
    const found = readyLayout(bench, name, of);
    if (found) return found;
    const names = readyOnes(bench).map(({ id }) => id);
    throw new Unreadable(`There is no ready layout “${name}” for this bench. There are: ${names.join(", ")}.`);
  }
  if (first === "saved") {
    const found = saved.peek().find((each) => each.name === name);
    if (found) return found;
    throw new Unreadable(`This browser has no layout “${name}” of this bench.`);
  }
  throw new Unreadable("This address names no layout.");
}

/** Show what was shown last, or the first ready layout. */
function openLast(): void {
  const bench = hello.peek();
  const first = bench && !current.peek() ? readyLayout(bench, "bench", "") : null;
  if (first) open(first, ["ready", "bench"]);
  else if (shownFor !== bench?.bench) {
    shownFor = bench?.bench;
    openings.value += 1;
  }
}

/** Show a layout. What was changed before and is not saved is put to the recent ones. */
export function open(found: Layout, from: string[]): void {
  const next = numbered(found);
  const before = current.peek();
  const known = before && (isAlike(before.layout, next) || saved.peek().some((each) => isAlike(each, before.layout)));
  if (before && !known && isChanged.peek()) recent.value = [before.layout, ...recent.peek()].slice(0, MOST_RECENT);
  coming.clear();
  settingsOf.value = "";
  const bench = hello.peek()?.bench;
  const isSame = before !== null && isAlike(before.layout, next) && shownFor === bench;
  shownFor = bench;
  current.value = { from, opened: next, layout: isSame ? { ...before.layout, name: next.name } : next };
  if (!isSame) openings.value += 1;
  void tellAddress();
}

// ---- changes ----

let telling: ReturnType<typeof setTimeout> | undefined;
const ADDRESS_MS = 300;

/** Take the layout as it was changed. */
export function change(next: Layout): void {
  const now = current.peek();
  const from = now?.from ?? [];
  current.value = { from, opened: now?.opened ?? emptyLayout(next.bench), layout: next };
  clearTimeout(telling);
  telling = setTimeout(() => void tellAddress(), ADDRESS_MS);
}

/** Put the layout into the address: the short one while it is as it was opened. */
async function tellAddress(): Promise<void> {
  const address = await addressOf();
  const isHere = /^#?\/?layout(\/|$)/.test(window.location.hash);
  if (isHere && window.location.hash !== address) window.history.replaceState(null, "", address);
}

/** Address at which anybody gets this layout. */
export async function addressOf(): Promise<string> {
  const now = current.peek();
  const isReady = now?.from[0] === "ready" && !isChanged.peek();
  return isReady ? href("layout", ...now.from) : href("layout", await textOfLayout(layout.peek()));
}

/** Name of what a panel keeps beside the layout, such as the window of its plot. */
export function keyOf(row: PanelRow, { name }: Layout): string {
  return `${name || "panel"} ${row.id}`;
}

export function changePanel(id: string, what: Partial<Pick<PanelRow, "of" | "given">>): void {
  change(withPanel(layout.peek(), id, what));
}

/** Change one of the things that a panel was given. */
export function give(row: PanelRow, given: Record<string, unknown>): void {
  const before = (rowOf(row.id) ?? row).given;
  const after = { ...before, ...given };
  if (JSON.stringify(after) !== JSON.stringify(before)) changePanel(row.id, { given: after });
}

/** Add a panel, if there is room. */
export function addPanel(row: PanelRow): void {
  if (isFull(layout.peek())) {
    notify(`A layout has at most ${MOST_PANELS} panels: close one first.`, true);
    return;
  }
  const known = new Set([...rows.peek().keys(), ...coming.keys()]);
  let number = known.size + 1;
  while (known.has(`p${number}`)) number++;
  const own = { ...row, id: `p${number}` };
  coming.set(own.id, own);
  arranger?.add(own);
}

/** Show the first of those panels that wait for room. */
export function showWaiting(): void {
  const [first, ...others] = layout.peek().waiting;
  if (!first || isFull(layout.peek())) return;
  change({ ...layout.peek(), waiting: others });
  addPanel(first);
}

export function rename(name: string): void {
  change({ ...layout.peek(), name });
}

/** Keep the layout by its name, in the place of one that has the name. */
export function save(): void {
  const now = layout.peek();
  const name = now.name.trim() || "mine";
  const mine = { ...now, name };
  saved.value = [mine, ...saved.peek().filter((each) => each.name !== name)].slice(0, MOST_SAVED);
  const before = current.peek();
  current.value = { from: ["saved", name], opened: mine, layout: mine };
  if (before) void tellAddress();
  notify(`The layout “${name}” is saved in this browser.`);
}

export function forget(name: string): void {
  saved.value = saved.peek().filter((each) => each.name !== name);
}
