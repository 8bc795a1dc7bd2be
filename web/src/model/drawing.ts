/** A drawing as the bench planned it, and what can be said of it. Pure. */

import { type DocumentProblem, readProblems } from "./problems";

export interface DrawingAxis {
  letter: string;
  axis: string;
  unit: string;
  deg_per_unit: number;
  zero_deg: number;
  /** Where it may be; null: the bench does not say so. */
  range: [number, number] | null;
}

/** One run of the drawing. `timeline`: at which second each line of the program begins. */
export interface DrawingPart {
  text: string;
  /** Digest of the text, which its run has too. */
  digest: string;
  duration_s: number;
  timeline: [number, number][];
  /** Line of the pause after it; null: the drawing ends. */
  pause_line: number | null;
}

export interface Drawing {
  /** What it is known by: that of program, machine and runs. */
  digest: string;
  machine: string;
  axes: DrawingAxis[];
  parts: DrawingPart[];
  remarks: DocumentProblem[];
  figures: { lines: number; duration_s: number; feed_mm: number; rapid_mm: number; range: [string, number, number][] };
  /** Positions of all axes, one point after the other. */
  places: Float64Array;
  count: number;
  isWhole: boolean;
  /** Point at which each line of the program begins. */
  lines: [number, number][];
  /** Points of rapids: from, to. */
  rapids: [number, number][];
  /** Texts that it was made of, where the bench told them. */
  text: string | null;
  machineText: string | null;
  file: string | null;
}

export interface DrawingProblems {
  of: "machine" | "program";
  problems: DocumentProblem[];
}

type Json = Record<string, unknown>;

/** Read the bench's answer; null: it is none. */
export function readDrawing(raw: unknown): Drawing | DrawingProblems | null {
  const told = object(raw);
  const problems = readProblems(told["problems"]);
  if (problems.length) return { of: told["of"] === "machine" ? "machine" : "program", problems };
  const path = object(told["path"]);
  const figures = object(told["figures"]);
  const axes = list(told["axes"]).map(readAxis);
  if (!axes.length || !Array.isArray(path["places"])) return null;
  const places = Float64Array.from(path["places"] as number[], Number);
  return {
    digest: textOf(told["digest"]) ?? "",
    machine: String(told["machine"] ?? ""),
    axes,
    parts: list(told["runs"]).map(readPart),
    remarks: readProblems(told["remarks"]),
    figures: {
      lines: numberOf(figures["lines"]),
      duration_s: numberOf(figures["duration_s"]),
      feed_mm: numberOf(figures["feed_mm"]),
      rapid_mm: numberOf(figures["rapid_mm"]),
      range: Object.entries(object(figures["range"])).map(([letter, ends]) => [letter, numberOf(list(ends)[0]), numberOf(list(ends)[1])]),
    },
    places,
    count: Math.floor(places.length / axes.length),
    isWhole: path["is_whole"] !== false,
    lines: list(path["lines"]).map(pair),
    rapids: list(path["rapids"]).map(pair),
    text: textOf(told["text"]),
    machineText: textOf(told["machine_text"]),
    file: textOf(told["file"]),
  };
}

/** Read the answer to a check: its problems, or its figures in words. */
export function readCheck(raw: unknown): DrawingProblems | string {
  const told = object(raw);
  const problems = readProblems(told["problems"]);
  if (problems.length) return { of: told["of"] === "machine" ? "machine" : "program", problems };
  const figures = object(told["figures"]);
  const remarks = list(told["remarks"]).length;
  const said = `${numberOf(figures["lines"])} lines, ${numberOf(figures["feed_mm"]).toFixed(1)} mm at a feed, ${numberOf(figures["duration_s"]).toFixed(1)} s`;
  return `${said}, no problems${remarks ? `, ${remarks} ${remarks === 1 ? "remark" : "remarks"}` : ""}`;
}

function readAxis(raw: unknown): DrawingAxis {
  const told = object(raw);
  return {
    letter: String(told["letter"] ?? "?"),
    axis: String(told["axis"] ?? ""),
    unit: String(told["unit"] ?? ""),
    deg_per_unit: numberOf(told["deg_per_unit"]) || 1,
    zero_deg: numberOf(told["zero_deg"]),
    range: list(told["range"]).length === 2 ? pair(told["range"]) : null,
  };
}

function readPart(raw: unknown): DrawingPart {
  const told = object(raw);
  return {
    text: String(told["text"] ?? ""),
    digest: textOf(told["digest"]) ?? "",
    duration_s: numberOf(told["duration_s"]),
    timeline: list(told["timeline"]).map(pair),
    pause_line: typeof told["pause_line"] === "number" ? told["pause_line"] : null,
  };
}

/** Number of the drawing's part that a run is, from 0; null: it is no run of this drawing. */
export function partOf(run: { digest: string }, made: Drawing): number | null {
  const number = run.digest === "" ? -1 : made.parts.findIndex((part) => part.digest === run.digest);
  return number < 0 ? null : number;
}

/** The first of so many of which something holds, where it holds of all behind it too; the number of all: of none. */
function firstWhere(count: number, holds: (at: number) => boolean): number {
  let [low, high] = [0, count];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (holds(middle)) high = middle;
    else low = middle + 1;
  }
  return low;
}

/** Line of the program at a time of a part's plan. */
export function lineAt(part: DrawingPart, gone_s: number): number {
  const next = firstWhere(part.timeline.length, (each) => part.timeline[each]![0] > gone_s);
  return part.timeline[Math.max(next - 1, 0)]?.[1] ?? 0;
}

/** Points of the path, from and to, between which the machine is on a line of the program. */
export function pointsOf(made: Drawing, line: number): [number, number] {
  const at = firstWhere(made.lines.length, (each) => made.lines[each]![1] >= line);
  if (at === made.lines.length) return [0, made.count];
  return [Math.max(made.lines[at]![0] - 1, 0), made.lines[at + 1]?.[0] ?? made.count];
}

/** Points of the path between which the machine is, with so much of a part's plan gone at least and at most. Within a
 * line it goes at most twice as far as evenly: a closed arc's beginning is not taken for its end. */
export function pointsBetween(made: Drawing, part: DrawingPart | undefined, least_s: number, most_s: number): [number, number] {
  if (!part) return [0, 0];
  const [from] = pointsOf(made, lineAt(part, least_s));
  const [first, last] = pointsOf(made, lineAt(part, most_s));
  const next = firstWhere(part.timeline.length, (each) => part.timeline[each]![0] > most_s);
  const begin_s = part.timeline[next - 1]?.[0] ?? 0;
  const end_s = part.timeline[next]?.[0] ?? part.duration_s;
  const share = end_s > begin_s ? Math.min(Math.max((2 * (most_s - begin_s)) / (end_s - begin_s), 0), 1) : 1;
  return [from, Math.max(from, first + Math.floor(share * (last - 1 - first)))];
}

/** Share of a drawing that is done, 0 to 1. */
export function shareDone(parts: DrawingPart[], number: number, gone_s: number): number {
  const whole = parts.reduce((sum, part) => sum + part.duration_s, 0);
  const before = parts.slice(0, number).reduce((sum, part) => sum + part.duration_s, 0);
  return whole > 0 ? Math.min((before + gone_s) / whole, 1) : 1;
}

/** Text of a file's bytes: UTF-8, or UTF-16 with its mark, or the old Western one. */
export function decoded(bytes: Uint8Array): string {
  if (bytes[0] === 0xff && bytes[1] === 0xfe) return new TextDecoder("utf-16le").decode(bytes);
  if (bytes[0] === 0xfe && bytes[1] === 0xff) return new TextDecoder("utf-16be").decode(bytes);
  try {
    return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("windows-1252").decode(bytes);
  }
}

function pair(raw: unknown): [number, number] {
  const both = list(raw);
  return [numberOf(both[0]), numberOf(both[1])];
}

function object(value: unknown): Json {
  return typeof value === "object" && value !== null && !Array.isArray(value) ? (value as Json) : {};
}

function list(value: unknown): unknown[] {
  return Array.isArray(value) ? value : [];
}

function numberOf(value: unknown): number {
  return typeof value === "number" && Number.isFinite(value) ? value : 0;
}

function textOf(value: unknown): string | null {
  return typeof value === "string" ? value : null;
}
