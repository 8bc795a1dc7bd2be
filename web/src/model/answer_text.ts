/** What a verb answered, in words: names with blanks, numbers with their units and no more digits than they are worth. Pure. */

import type { FieldRow, VerbRow } from "./door";
import { digitsOf, shown } from "./numbers";

const UNITS = ["deg", "rpm", "Nm", "A", "V", "Hz", "mm", "ms", "us", "s"];
const ANGLES = ["deg", "rpm", "Nm"];

/** Text of an answer; empty: it says nothing but that it was done. */
export function answerText(answer: unknown, verb: Pick<VerbRow, "parameters">, fields: readonly Pick<FieldRow, "name">[]): string {
  if (typeof answer !== "object" || answer === null) return "";
  return Object.entries(answer)
    .filter(([name]) => !name.endsWith("_ns"))
    .map(([name, value]) => part(name, value, verb, fields))
    .join(", ");
}

function part(name: string, value: unknown, verb: Pick<VerbRow, "parameters">, fields: readonly Pick<FieldRow, "name">[]): string {
  const unit = name === "set_point" ? unitOfSetPoint(verb, fields) : (UNITS.find((each) => name.endsWith(`_${each}`)) ?? "");
  const words = name === "set_point" ? "set-point" : name.slice(0, name.length - (unit ? unit.length + 1 : 0)).replaceAll("_", " ");
  return `${words} ${valueText(value, unit)}`;
}

/** Unit of a set-point that a verb answers: that of what it was given. A board with modes may mean an angle or a velocity. */
function unitOfSetPoint(verb: Pick<VerbRow, "parameters">, fields: readonly Pick<FieldRow, "name">[]): string {
  const given = verb.parameters.map(({ unit }) => unit).find((unit) => ANGLES.includes(unit));
  return given ?? (fields.some(({ name }) => name === "mode") ? "" : "deg");
}

function valueText(value: unknown, unit: string): string {
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (typeof value !== "number") return typeof value === "string" ? value : JSON.stringify(value);
  const text = Number.isInteger(value) ? String(value) : shown(value, unit ? digitsOf(unit) : 3);
  return unit ? `${text} ${unit}` : text;
}
