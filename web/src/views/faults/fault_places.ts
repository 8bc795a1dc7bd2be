/** Places where faults can be, as a tree, with the kinds that fit each. Pure. */

import type { FaultKindRow, Operations } from "../../model/door";

export type PlaceRow = Operations["fault_places"]["answer"][number];

export interface PlaceNode {
  readonly row: PlaceRow;
  /** Name within what it stands under. */
  readonly label: string;
  readonly parts: readonly PlaceNode[];
}

/** Devices with their parts, and wires with what is on them. */
export interface PlaceTree {
  readonly devices: readonly PlaceNode[];
  readonly wires: readonly PlaceNode[];
}

export function placeTree(rows: readonly PlaceRow[]): PlaceTree {
  const parts = (of: string) => rows.filter((row) => row.of === of && row.sort !== "tap").map((row) => leaf(row, row.place.slice(of.length + 1)));
  const stations = (wire: string) =>
    rows.filter((row) => row.wire === wire && row.sort !== "wire").map((row) => leaf(row, row.sort === "tap" ? row.place.slice(wire.length + 1) : row.place));
  return {
    devices: rows.filter(({ sort }) => sort === "device" || sort === "board").map((row) => ({ row, label: row.place, parts: parts(row.place) })),
    wires: rows.filter(({ sort }) => sort === "wire").map((row) => ({ row, label: row.place, parts: stations(row.place) })),
  };
}

function leaf(row: PlaceRow, label: string): PlaceNode {
  return { row, label, parts: [] };
}

const SORTS: Record<string, string> = { device: "board", board: "real board", port: "port", axis: "axis", node: "node", tap: "tap", wire: "wire" };

export function sortText(row: PlaceRow): string {
  return SORTS[row.sort] ?? row.sort;
}

/** Families of faults, each with a drawing. */
export const FAMILIES = {
  encoder: "Encoder",
  shaft: "Shaft and load",
  coil: "Motor driver",
  supply: "Power",
  board: "Board and processor",
  cable: "Serial port",
  packet: "Packets and answers",
  wire: "Wire and drivers",
} as const;
export type Family = keyof typeof FAMILIES;

const OF_KINDS: [RegExp, Family][] = [
  [/^(encoder_|bus_no_answer)/, "encoder"],
  [/^(shaft_|steps_)/, "shaft"],
  [/^(phase_|thermal_)/, "coil"],
  [/^(supply_|node_reset|node_brown_out|chip_brown_out)/, "supply"],
  [/^(chip_|node_hang|field_|switch_)/, "board"],
  [/^(byte_|host_)/, "cable"],
  [/^(packet_|modbus_)/, "packet"],
];

export function familyOf(kind: string): Family {
  return OF_KINDS.find(([pattern]) => pattern.test(kind))?.[1] ?? "wire";
}

/** Kinds that fit a place, by family, in the order of the families. */
export function fitting(row: PlaceRow | undefined, kinds: readonly FaultKindRow[]): [Family, FaultKindRow[]][] {
  const names = new Set(row?.kinds ?? []);
  return (Object.keys(FAMILIES) as Family[])
    .map((family): [Family, FaultKindRow[]] => [family, kinds.filter((kind) => names.has(kind.name) && familyOf(kind.name) === family)])
    .filter(([, found]) => found.length > 0);
}

/** Fault that is kept under a name, to be injected again. */
export interface Preset {
  readonly name: string;
  readonly kind: string;
  readonly place: string;
  readonly texts: Readonly<Record<string, string>>;
}

const MOST_PRESETS = 50;

/** Read what was kept; what is no preset is left out. */
export function readPresets(raw: unknown): readonly Preset[] {
  if (!Array.isArray(raw)) return [];
  return raw.slice(0, MOST_PRESETS).flatMap((each: unknown) => {
    const { name, kind, place, texts } = (each ?? {}) as Record<string, unknown>;
    if (typeof name !== "string" || typeof kind !== "string" || typeof place !== "string") return [];
    const read = Object.entries(typeof texts === "object" && texts !== null ? texts : {});
    return [{ name, kind, place, texts: Object.fromEntries(read.filter((entry): entry is [string, string] => typeof entry[1] === "string")) }];
  });
}

/** Presets with one more; one of the same name is replaced. */
export function withPreset(presets: readonly Preset[], preset: Preset): readonly Preset[] {
  return [...presets.filter(({ name }) => name !== preset.name), preset].slice(-MOST_PRESETS);
}

/** Say when a fault is: "for 5 s, again every 30 s". */
export function timingText(parameters: Readonly<Record<string, unknown>>): string {
  const time = (name: string) => (typeof parameters[name] === "number" ? (parameters[name] as number) : 0);
  const parts = [time("for_s") ? `for ${time("for_s")} s` : "", time("every_s") ? `again every ${time("every_s")} s` : ""];
  return parts.filter(Boolean).join(", ");
}
