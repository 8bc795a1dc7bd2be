/** Check of what is typed into a form, by the table's row: the same limits as the bench's. Pure. */

import type * as door from "./door";
import { plain } from "./numbers";

/** Parameter of a table, or of a form of the page, which has less. */
export type ParameterRow = Pick<door.ParameterRow, "name"> & Partial<door.ParameterRow>;

export type Form = "choice" | "text" | "flag" | "number" | "whole" | "json";

export function formOf(row: ParameterRow): Form {
  if (row.choices && row.choices.length > 0) return "choice";
  const type = row.type ?? "";
  if (/^(text|str|string)/.test(type)) return "text";
  if (/^(flag|bool)/.test(type)) return "flag";
  if (/^(object|list|json|form|array)/.test(type)) return "json";
  return /^(whole|int|i32|i64)/.test(type) ? "whole" : "number";
}

/** Whether it may be left out. */
export function isOptional(row: ParameterRow): boolean {
  return row.is_optional === true || (row.default !== null && row.default !== undefined);
}

/** Text of limits and unit, for people: "0 to 3000 rpm". */
export function limitsOf(row: ParameterRow): string {
  const unit = row.unit ? ` ${row.unit}` : "";
  const form = formOf(row);
  if (form === "choice" || form === "flag") return "";
  if (form === "text") return row.maximum ? `at most ${plain(row.maximum)} characters` : "";
  if (row.limits) return `${row.limits}${row.unit ? `, in ${row.unit}` : ""}`;
  const { minimum, maximum } = row;
  if (typeof minimum === "number" && typeof maximum === "number") return `${plain(minimum)} to ${plain(maximum)}${unit}`;
  return unit.trim();
}

export type Checked = { value: unknown } | { problem: string } | { isLeftOut: true };

/** Check a typed text against its row. */
export function check(row: ParameterRow, typed: string): Checked {
  const form = formOf(row);
  if (form === "text") return checkText(row, typed);
  const trimmed = typed.trim();
  if (trimmed === "") return isOptional(row) ? { isLeftOut: true } : { problem: "this one is missing" };
  if (form === "choice") {
    return row.choices?.includes(trimmed) ? { value: trimmed } : { problem: `choose ${row.choices?.join(" or ")}` };
  }
  if (form === "flag") return { value: trimmed === "true" };
  if (form === "json") return checkJson(trimmed);
  return checkNumber(row, trimmed, form === "whole");
}

function checkText(row: ParameterRow, typed: string): Checked {
  if (typed === "" && isOptional(row)) return { isLeftOut: true };
  const most = row.maximum ?? Infinity;
  return [...typed].length <= most ? { value: typed } : { problem: `write at most ${plain(most)} characters` };
}

function checkJson(typed: string): Checked {
  try {
    return { value: JSON.parse(typed) as unknown };
  } catch {
    return { problem: "write JSON" };
  }
}

const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;

function checkNumber(row: ParameterRow, typed: string, isWhole: boolean): Checked {
  const value = Number(typed.replace("−", "-"));
  if (!NUMBER.test(typed.replace("−", "-")) || !Number.isFinite(value)) return { problem: "write a number" };
  const { minimum, maximum } = row;
  if ((typeof minimum === "number" && value < minimum) || (typeof maximum === "number" && value > maximum)) {
    return { problem: `write ${limitsOf(row)}` };
  }
  return isWhole && !Number.isInteger(value) ? { problem: "write a whole number" } : { value };
}

/** Check all fields of a form: the values to send, and problems by name. */
export function checkAll(rows: ParameterRow[], typed: Record<string, string>): { values: Record<string, unknown>; problems: Record<string, string> } {
  const values: Record<string, unknown> = {};
  const problems: Record<string, string> = {};
  for (const row of rows) {
    const checked = check(row, typed[row.name] ?? "");
    if ("value" in checked) values[row.name] = checked.value;
    else if ("problem" in checked) problems[row.name] = checked.problem;
  }
  return { values, problems };
}
