/** Layouts of panels: what stands where, and what each panel shows. Pure: as data, as text, with what may be wrong in them. */

/** Another form of a layout has another number. */
export const LAYOUT_VERSION = 1;
/** So many panels are shown; more wait. */
export const MOST_PANELS = 48;
const MOST_TEXT = 200;
const MOST_DEPTH = 12;
/** All shares of a split together. */
const WHOLE = 1000;

export const PANEL_KINDS = ["plot", "number", "picture", "events", "wire", "terminal", "verbs", "gains", "pins", "fields", "faults", "path", "runs"] as const;
export type PanelKind = (typeof PANEL_KINDS)[number];

/** What a panel shows, and of what: a device, a port, a wire; empty: of the bench. */
export interface PanelRow {
  /** Tells it from the layout's others. */
  id: string;
  kind: PanelKind;
  of: string;
  given: Readonly<Record<string, unknown>>;
}

/** Panels in one place, one of which is in sight. */
export interface Tabs {
  tabs: PanelRow[];
  shown: number;
}

/** Places beside each other; their parts are below each other, and so on in turn. */
export interface Split {
  parts: Place[];
  /** Of each part, of 1000. */
  shares: number[];
}

export type Place = Tabs | Split;

export interface Layout {
  version: number;
  name: string;
  /** Bench that it was made for. */
  bench: string;
  /** Without controls: nothing in it changes the bench. */
  isWatch: boolean;
  /** Whether the outermost parts are below each other. */
  isColumn: boolean;
  root: Place | null;
  /** Panels beyond those that are shown. They are kept. */
  waiting: PanelRow[];
}

/** Why a layout cannot be read, in words. */
export class Unreadable extends Error {}

export function emptyLayout(bench: string, name = ""): Layout {
  return { version: LAYOUT_VERSION, name, bench, isWatch: false, isColumn: false, root: null, waiting: [] };
}

export function isTabs(place: Place): place is Tabs {
  return "tabs" in place;
}

/** All panels of a place, from left to right and from above. */
export function panelsOf(place: Place | null): PanelRow[] {
  if (!place) return [];
  return isTabs(place) ? place.tabs : place.parts.flatMap(panelsOf);
}

export function panel(kind: PanelKind, of = "", given: Record<string, unknown> = {}): PanelRow {
  return { id: "", kind, of, given };
}

export function tabs(...rows: PanelRow[]): Tabs {
  return { tabs: rows, shown: 0 };
}

/** Places with their weights. Those without panels are left out. */
export function split(...parts: [number, Place | null][]): Place | null {
  const there = parts.filter((part): part is [number, Place] => part[1] !== null && panelsOf(part[1]).length > 0);
  if (there.length < 2) return there[0]?.[1] ?? null;
  return {
    parts: there.map(([, place]) => place),
    shares: sharesOf(
      there.map(([weight]) => weight),
      there.length,
    ),
  };
}

/** Shares of 1000 for weights; equal ones where they are no weights. */
export function sharesOf(weights: readonly unknown[], count: number): number[] {
  const isSound = weights.length === count && weights.every((each) => typeof each === "number" && Number.isFinite(each) && each > 0);
  const sound = isSound ? (weights as number[]) : Array.from({ length: count }, () => 1);
  const sum = sound.reduce((all, each) => all + each, 0);
  return sound.map((each) => Math.max(Math.round((each / sum) * WHOLE), 1));
}

// ---- reading ----

/** Read a layout of unknown origin. Throws Unreadable. */
export function readLayout(raw: unknown): Layout {
  const told = objectOf(raw);
  if (!told) throw new Unreadable("This is no layout.");
  if (told["version"] !== LAYOUT_VERSION) {
    throw new Unreadable(`This layout has the version ${String(told["version"]).slice(0, 20)}; this page reads version ${LAYOUT_VERSION}.`);
  }
  const room = { left: MOST_PANELS, over: [] as PanelRow[] };
  const root = readPlace(told["root"], room, 0);
  const waiting = Array.isArray(told["waiting"]) ? told["waiting"].flatMap((each) => readPanel(each) ?? []) : [];
  return {
    version: LAYOUT_VERSION,
    name: textOf(told["name"]),
    bench: textOf(told["bench"]),
    isWatch: told["isWatch"] === true,
    isColumn: told["isColumn"] === true,
    root,
    waiting: [...room.over, ...waiting],
  };
}

function readPlace(raw: unknown, room: { left: number; over: PanelRow[] }, depth: number): Place | null {
  const told = objectOf(raw);
  if (!told || depth > MOST_DEPTH) return null;
  if (Array.isArray(told["tabs"])) {
    const rows = told["tabs"].flatMap((each) => readPanel(each) ?? []);
    const shown = rows.slice(0, room.left);
    room.left -= shown.length;
    room.over.push(...rows.slice(shown.length));
    if (!shown.length) return null;
    const at = told["shown"];
    return { tabs: shown, shown: typeof at === "number" && at >= 0 && at < shown.length ? Math.floor(at) : 0 };
  }
  if (!Array.isArray(told["parts"])) return null;
  const weights = Array.isArray(told["shares"]) ? told["shares"] : [];
  const parts = told["parts"].map((each, at): [unknown, Place | null] => [weights[at], readPlace(each, room, depth + 1)]);
  const there = parts.filter((part): part is [unknown, Place] => part[1] !== null);
  if (!there.length) return null;
  return {
    parts: there.map(([, place]) => place),
    shares: sharesOf(
      there.map(([weight]) => weight),
      there.length,
    ),
  };
}

function readPanel(raw: unknown): PanelRow | undefined {
  const told = objectOf(raw);
  const kind = PANEL_KINDS.find((each) => each === told?.["kind"]);
  if (!told || !kind) return undefined;
  return { id: "", kind, of: textOf(told["of"]), given: objectOf(told["given"]) ?? {} };
}

function objectOf(raw: unknown): Record<string, unknown> | null {
  return typeof raw === "object" && raw !== null && !Array.isArray(raw) ? (raw as Record<string, unknown>) : null;
}

function textOf(raw: unknown): string {
  return typeof raw === "string" ? raw.slice(0, MOST_TEXT) : "";
}

// ---- what a panel was given ----

export function givenText(row: PanelRow, name: string, otherwise = ""): string {
  const value = row.given[name];
  return typeof value === "string" ? value.slice(0, MOST_TEXT) : otherwise;
}

export function givenNumber(row: PanelRow, name: string): number | null {
  const value = row.given[name];
  return typeof value === "number" && Number.isFinite(value) ? value : null;
}

export function givenTexts(row: PanelRow, name: string): string[] {
  const value = row.given[name];
  return Array.isArray(value) ? value.filter((each): each is string => typeof each === "string").slice(0, 64) : [];
}
