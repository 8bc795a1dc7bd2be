/** Which fields of an axis belong where: plots by unit, digital levels, set-points. Pure, by the bench's table. */

import { boardAngleOf } from "../../model/sampled_places";
import type { DeviceRow, FieldRow } from "../../model/door";

export interface Pane {
  /** Tells it from the axis's other panes. */
  key: string;
  unit: string;
  title: string;
  fields: PaneField[];
  /** Unit of its right axis; undefined: it has none. */
  rightUnit?: string;
}

/** Field as a pane draws it. */
export interface PaneField extends FieldRow {
  isRight: boolean;
}

const TITLES: Record<string, string> = {
  deg: "Position and set-point",
  rpm: "Velocity",
  Nm: "Effort",
  A: "Current",
  V: "Voltage",
};
const UNITS = ["deg", "rpm", "Nm", "A", "V"];
/** Shown without being chosen, if the axis has them, beside its set-point. */
const USUAL = ["position_deg", "yw", "velocity_rpm", "speed_rpm", "torque_Nm", "load_torque_Nm", "current_a_A", "current_b_A"];
const SETPOINTS = ["to_be_deg", "commanded_deg", "set_point_deg", "target_deg", "r"];

export function setpointOf(device: DeviceRow): string | undefined {
  const names = new Set(device.fields.map((field) => field.name));
  return SETPOINTS.find((name) => names.has(name)) ?? device.fields.find((field) => field.unit === "deg" && /^set-point/.test(field.meaning))?.name;
}

export function usualFields(device: DeviceRow): string[] {
  const setpoint = setpointOf(device);
  const usual = device.fields.map((field) => field.name).filter((name) => name === setpoint || USUAL.includes(name));
  return usual.length ? usual : ownFields(device).slice(0, MOST_OWN);
}

const MOST_OWN = 4;

/** Fields of a board without a motor and without pins: its own. */
export function ownFields(device: DeviceRow): string[] {
  if (Object.keys(device.inputs).length || device.fields.some(({ name }) => name === "position_deg")) return [];
  return device.fields.filter((field) => field.is_state && field.name !== "at_ns").map(({ name }) => name);
}

/** Fields that can be drawn: all but the time itself. */
export function drawable(device: DeviceRow): FieldRow[] {
  return device.fields.filter((field) => field.name !== "at_ns");
}

/** Units of a closed loop's set-point and its error by its mode, where they are no angles: velocity, torque. */
const SETPOINT_UNITS: Record<number, string> = { 118: "rpm", 116: "" };
const BY_MODE = ["r", "e"];
const SHAFT = "shaft";

/** Whether a field's unit depends on the mode of the axis's loop at each moment. */
export function isByMode(device: DeviceRow, name: string): boolean {
  return BY_MODE.includes(name) && device.fields.some((field) => field.name === "mode");
}

/** Unit of such a field in a mode. */
export function unitIn(mode: number): string {
  return SETPOINT_UNITS[mode] ?? "deg";
}

/** Fields to watch for those that are drawn. */
export function neededFields(device: DeviceRow, chosen: readonly string[]): string[] {
  if (!chosen.length)
    return drawable(device)
      .slice(0, 1)
      .map(({ name }) => name); // its times are those of all others
  return chosen.some((name) => isByMode(device, name)) ? [...new Set([...chosen, "mode"])] : [...chosen];
}

/** Fields of another axis that can be drawn beside an axis's own: named with its address. */
export function fieldsBeside(device: DeviceRow): FieldRow[] {
  return drawable(device).map((field) => ({ ...field, name: `${device.name}.${field.name}`, meaning: `${device.name}: ${field.meaning}` }));
}

/** Split the name of such a field into axis and field; null: it is the axis's own. */
export function besideOf(name: string): { axis: string; field: string } | null {
  const dot = name.lastIndexOf(".");
  return dot < 0 ? null : { axis: name.slice(0, dot), field: name.slice(dot + 1) };
}

/** Split an address of a field, as "m1.yw", into a device of the bench and its row; null: there is none such. */
export function fieldAt(devices: ReadonlyMap<string, DeviceRow>, address: string): { device: DeviceRow; field: FieldRow } | null {
  const parts = besideOf(address);
  const device = parts ? devices.get(parts.axis) : undefined;
  const field = device?.fields.find(({ name }) => name === parts?.field);
  return device && field ? { device, field } : null;
}

/** Field in the pane where it is drawn. */
interface Placed {
  key: string;
  field: PaneField;
}

/** Make the panes for chosen fields: one for each unit, the usual units first. The shaft's angle has its own where the
 * board's has another zero; `modes`: those that the loop has had, by which its set-point has units; `others`: fields of other
 * axes, once for each unit that they have had; `right`: panes at whose right axis fields are drawn, by name. */
export function panesOf(
  device: DeviceRow,
  chosen: readonly string[],
  modes: Iterable<number> = [],
  others: readonly FieldRow[] = [],
  right: Readonly<Record<string, string>> = {},
): Pane[] {
  const hasTwoZeros = boardAngleOf(device.fields) !== undefined;
  const unitsByMode = [...new Set([...modes].map(unitIn))];
  const placed: Placed[] = drawable(device)
    .filter((field) => chosen.includes(field.name))
    .flatMap((field) => {
      const units = isByMode(device, field.name) && unitsByMode.length ? unitsByMode : [field.unit];
      const isShaft = hasTwoZeros && field.name === "position_deg";
      return units.map((unit) => ({ key: isShaft ? SHAFT : unit, field: { ...field, unit, isRight: false } }));
    });
  const keyBeside = ({ name, unit }: FieldRow) => (hasTwoZeros && name.endsWith(".position_deg") ? SHAFT : unit);
  placed.push(...others.map((field) => ({ key: keyBeside(field), field: { ...field, isRight: false } })));
  const moved = movedRight(placed, right);
  const keys = [...new Set(moved.map(({ key }) => key))];
  const rank = (key: string) => (key === SHAFT ? -1 : UNITS.includes(key) ? UNITS.indexOf(key) : UNITS.length);
  keys.sort((a, b) => rank(a) - rank(b));
  return keys.map((key) => {
    const fields = moved.filter((each) => each.key === key).map(({ field }) => field);
    const rightUnit = fields.find(({ isRight }) => isRight)?.unit;
    const unit = fields.find(({ isRight }) => !isRight)!.unit;
    return { key, unit, title: titleOf(key, hasTwoZeros), fields, ...(rightUnit === undefined ? {} : { rightUnit }) };
  });
}

/** Move fields to the right axes of other panes: of those that keep a field at their left, and of one unit for each. */
function movedRight(placed: Placed[], right: Readonly<Record<string, string>>): Placed[] {
  const staying = new Set(placed.filter(({ key, field }) => (right[field.name] ?? key) === key).map(({ key }) => key));
  const units = new Map<string, string>();
  return placed.map(({ key, field }) => {
    const to = right[field.name] ?? key;
    if (to === key || !staying.has(to) || (units.get(to) ?? field.unit) !== field.unit) return { key, field };
    units.set(to, field.unit);
    return { key: to, field: { ...field, isRight: true } };
  });
}

/** Key of the range of values of a pane's axis. */
export function rangeKey(pane: Pane, isRight: boolean): string {
  return isRight ? `${pane.key} right` : pane.key;
}

function titleOf(key: string, hasTwoZeros: boolean): string {
  if (key === SHAFT) return "Shaft's angle";
  if (key === "deg" && hasTwoZeros) return "Board's angle and set-point";
  return TITLES[key] ?? (key ? `In ${key}` : "Without unit");
}

export interface PinRow {
  name: string;
  /** Field that tells its level; empty: none does. */
  field: string;
  /** Bit of the field that is its level; null: the whole field is. */
  bit: number | null;
  /** Whether it can be driven from here. */
  isInput: boolean;
  meaning: string;
}

/** Pins of an axis: its inputs, in their order, then other levels that its fields tell. */
export function pinsOf(device: DeviceRow): PinRow[] {
  const meanings = new Map(device.fields.map((field) => [field.name, field.meaning]));
  const inputs = Object.entries(device.inputs).map(([name, told]) => {
    const [of = "", number] = told.split("."); // pin_levels.13: a microcontroller has all its pins in one field
    const field = meanings.has(of) ? of : "";
    const bit = number === undefined || !field ? null : Number(number);
    return { name, field, bit, isInput: true, meaning: bit === null ? (meanings.get(field) ?? "") : "" };
  });
  const known = new Set(inputs.map((pin) => pin.field));
  const others = device.fields
    .filter((field) => isLevel(field) && !known.has(field.name))
    .map((field) => ({ name: field.name.replace(/^pin_/, ""), field: field.name, bit: null, isInput: false, meaning: field.meaning }));
  return [...inputs, ...others];
}

/** Level of a pin, of the value of its field. */
export function levelOf(value: number, bit: number | null): number {
  return bit === null || Number.isNaN(value) ? value : (value >> bit) & 1;
}

function isLevel(field: FieldRow): boolean {
  return field.unit === "" && field.type.startsWith("i") && (/^pin_/.test(field.name) || /^(driver pin|input|output)\b/.test(field.meaning));
}
