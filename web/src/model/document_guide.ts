/** What may stand at a place of a run or of a machine, on the bench that there is. Pure. */

import type { DeviceRow } from "./door";
import { type KeyRow, PARTS } from "./document_words";
import { plain } from "./numbers";
import type { YamlPlace } from "./yaml_place";

export type DocumentKind = "RunDocument" | "MachineText";

/** Something that may be written. `insert`: what is, where it is not its name. */
export interface Offer {
  name: string;
  kind: "key" | "axis" | "value";
  detail: string;
  about: string;
  insert?: string;
}

interface Part {
  rows: readonly KeyRow[];
  /** Row of the mapping whose keys are names of axes or inputs. */
  names: KeyRow | null;
  takesAxes: boolean;
}

/** Devices that may take part in runs. */
export function runAxes(devices: Iterable<DeviceRow>): DeviceRow[] {
  return [...devices].filter(({ verbs }) => "stop" in verbs && ("move_abs" in verbs || "position" in verbs));
}

function partAt(kind: DocumentKind, path: readonly string[]): Part | null {
  let part: Part = { rows: PARTS[kind] ?? [], names: null, takesAxes: false };
  for (const key of path) {
    const row: KeyRow | undefined = part.names ?? part.rows.find(({ name }) => name === key);
    if (!row) return null;
    if (part.names === null && row.names) part = { rows: [], names: row, takesAxes: false };
    else if (row.part) part = { rows: PARTS[row.part] ?? [], names: null, takesAxes: row.part === "SplinePoint" };
    else return null;
  }
  return part;
}

/** Row of the value at a place; null: it is not known. */
function rowAt(kind: DocumentKind, path: readonly string[], key: string): KeyRow | null {
  const part = partAt(kind, path);
  return part?.names ?? part?.rows.find(({ name }) => name === key) ?? null;
}

/** What may be written at a place. */
export function offersAt(kind: DocumentKind, place: YamlPlace, devices: Iterable<DeviceRow>): Offer[] {
  const axes = runAxes(devices);
  if (place.key !== null) {
    const row = rowAt(kind, place.path, place.key);
    return row ? values(row, place, axes) : [];
  }
  const within = place.path.at(-1);
  const own = within === undefined ? null : rowAt(kind, place.path.slice(0, -1), within);
  if (own?.value === "axis" && own.isList) return axes.map((axis) => axisOffer(axis, axis.name));
  const part = partAt(kind, place.path);
  if (!part) return [];
  const keys = part.rows.map((row): Offer => ({ name: row.name, kind: "key", detail: rangeOf(row), about: row.about, insert: `${row.name}: ` }));
  if (part.names?.names === "input") return inputs(axes).map((pin) => ({ ...pin, insert: `${pin.name}: ` }));
  const named = part.names || part.takesAxes ? axes.map((axis) => axisOffer(axis, `${axis.name}: `)) : [];
  return [...keys, ...named];
}

function values(row: KeyRow, place: YamlPlace, axes: DeviceRow[]): Offer[] {
  const offer = (name: string, detail: string): Offer => ({ name, kind: "value", detail, about: row.about });
  if (row.names && !place.path.includes(row.name)) {
    if (row.names === "input") return inputs(axes).map((pin) => ({ ...pin, insert: `{${pin.name}: 1}` }));
    return axes.map((axis) => axisOffer(axis, `{${axis.name}: ${row.part ? "{}" : "0"}}`));
  }
  if (row.choices) return row.choices.map((choice) => offer(choice, choice === String(row.default) ? "as if left out" : ""));
  if (row.value === "flag") return ["true", "false"].map((each) => offer(each, each === String(row.default) ? "as if left out" : ""));
  if (row.value === "axis") return axes.map((axis) => axisOffer(axis, axis.name));
  if (row.value === "input") return inputs(axes);
  if (row.value === "field") return fields(axes);
  if (row.value !== "number" && row.value !== "whole") return [];
  const bound = boundOf(row, place, axes);
  const unit = row.unit ?? "";
  const offers: Offer[] = [];
  if (row.default !== undefined && row.default !== null) offers.push(offer(String(row.default), `${unit}, as if left out`));
  if (bound) offers.push(offer(String(bound.maximum), `${unit}, the most that ${bound.axis} takes`));
  else if (row.maximum !== undefined && row.maximum !== row.default) offers.push(offer(String(row.maximum), `${unit}, the most`));
  return offers;
}

function axisOffer(axis: DeviceRow, insert: string): Offer {
  return { name: axis.name, kind: "axis", detail: axis.profile, about: `Axis of this bench, a ${axis.profile}.`, insert };
}

function inputs(axes: DeviceRow[]): Offer[] {
  return axes.flatMap((axis) =>
    Object.keys(axis.inputs).map((pin): Offer => ({ name: `${axis.name}.${pin}`, kind: "value", detail: "input", about: `Input ${pin} of ${axis.name}.` })),
  );
}

function fields(axes: DeviceRow[]): Offer[] {
  const known = new Map<string, Offer>();
  for (const axis of axes)
    for (const field of axis.fields)
      if (!known.has(field.name)) known.set(field.name, { name: field.name, kind: "value", detail: field.unit, about: field.meaning });
  return [...known.values()];
}

/** Bound that the board of the axis has, at whose key the place is. */
function boundOf(row: KeyRow, place: YamlPlace, axes: DeviceRow[]): { axis: string; minimum: number; maximum: number } | null {
  const axis = axes.find(({ name }) => name === place.path.at(-1));
  if (!axis) return null;
  for (const verb of ["stop", "position" in axis.verbs ? "" : "move_abs"]) {
    const asked = axis.verbs[verb]?.parameters.find(({ name }) => name === row.name);
    if (asked?.minimum !== undefined && asked.maximum !== undefined) return { axis: axis.name, minimum: asked.minimum, maximum: asked.maximum };
  }
  return null;
}

/** Range and unit of a key's value, in words. */
function rangeOf(row: KeyRow): string {
  const unit = row.unit ? ` ${row.unit}` : "";
  if (row.choices) return row.choices.join(" or ");
  if (row.minimum === undefined || row.maximum === undefined) return row.value === "mapping" || row.value === "text" ? "" : row.value + unit;
  return `${plain(row.minimum)} to ${plain(row.maximum)}${unit}`;
}

/** What a key, or the name of an axis, means at a place; empty: it is not known. */
export function explained(kind: DocumentKind, place: YamlPlace, word: string, devices: Iterable<DeviceRow>): string {
  const axes = runAxes(devices);
  const axis = axes.find(({ name }) => name === word);
  const key = place.key ?? word;
  const part = partAt(kind, place.path);
  if (axis && (part?.names || part?.takesAxes || place.key !== null)) return `${word}: axis of this bench, a ${axis.profile}`;
  const row = part?.names ? null : part?.rows.find(({ name }) => name === key);
  if (!row) return "";
  const bound = boundOf(row, place, axes);
  const takes = bound ? `; ${bound.axis} takes ${plain(bound.minimum)} to ${plain(bound.maximum)} ${row.unit ?? ""}` : "";
  const range = rangeOf(row);
  return `${key}: ${row.about || row.value}${range ? ` (${range}${takes})` : takes}`;
}
