/** The protocol between door and page: its types, and the decoding of frames. Pure: no socket here. */

import {
  type DeviceRow,
  type FaultKindRow,
  type FieldRow,
  type Greeting,
  type LineRow,
  type ParameterRow,
  type Role,
  SAMPLES,
  SAMPLES_HEAD,
  TERMINAL,
  TERMINAL_HEAD,
  TIMED,
  TIMED_HEAD,
  type VerbRow,
} from "../model/door";

/** Description of a bench as the page has it: its greeting, with the segments by name. */
export interface Hello extends Omit<Greeting, "segments"> {
  segments: string[];
  lines: ReadonlyMap<string, LineRow>;
}

/** A refusal by the bench, or "gone": the connection went before the answer came. */
export class Refused extends Error {
  constructor(
    readonly code: string,
    message: string,
    readonly problems: unknown[] = [],
  ) {
    super(message);
  }
}

export type ServerMessage =
  | { kind: "hello"; hello: Hello; isChange: boolean }
  | { kind: "answer"; id: number; answer: unknown }
  | { kind: "error"; id: number; error: Refused }
  | { kind: "push"; watch: number; items?: unknown[]; value?: unknown; lost: number }
  | { kind: "taken"; terminal: number; bytes: number }
  | { kind: "closed"; what: "terminal" | "watch"; number: number; why: string }
  | { kind: "unknown" };

/** Limit of messages where the server tells none. */
const MESSAGE_BYTES = 64 * 1024;

type Json = Record<string, unknown>;

function isObject(value: unknown): value is Json {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function list<T>(value: unknown): T[] {
  return Array.isArray(value) ? (value as T[]) : [];
}

function text(value: unknown): string {
  return typeof value === "string" ? value : "";
}

function texts(value: unknown): string[] {
  return list(value).filter((each) => typeof each === "string");
}

/** Read what the server told about the bench; what is missing is empty. */
export function readHello(raw: unknown): Hello {
  const told = isObject(raw) ? raw : {};
  const role = told["role"];
  const segments = list(told["segments"]).map(readLine);
  return {
    protocol: Number(told["protocol"] ?? 0),
    version: text(told["version"]),
    bench: text(told["bench"]),
    instance: text(told["instance"]),
    message_bytes: Number(told["message_bytes"] ?? 0) || MESSAGE_BYTES,
    user: text(told["user"]),
    role: role === "operator" || role === "admin" ? role : "viewer",
    devices: list<Json>(told["devices"]).filter(isObject).map(readDevice),
    segments: segments.map((line) => line.name),
    lines: new Map(segments.map((line) => [line.name, line])),
    buses: texts(told["buses"]),
    ports: texts(told["ports"]),
    operations: (isObject(told["operations"]) ? told["operations"] : {}) as Hello["operations"],
    fault_kinds: list<Json>(told["fault_kinds"]).filter(isObject).map(readFaultKind),
  };
}

function readLine(raw: unknown): LineRow {
  const told = isObject(raw) ? raw : { name: raw };
  return { name: text(told["name"]), framing: text(told["framing"]), baud: Number(told["baud"] ?? 0), format: text(told["format"]) };
}

function readDevice(raw: Json): DeviceRow {
  const verbs: Record<string, VerbRow> = Object.create(null) as Record<string, VerbRow>;
  for (const [name, verb] of Object.entries(isObject(raw["verbs"]) ? raw["verbs"] : {})) {
    if (isObject(verb)) {
      verbs[name] = {
        summary: text(verb["summary"]),
        role: (text(verb["role"]) || "operator") as Role,
        parameters: readParameters(verb["parameters"]),
      };
    }
  }
  return {
    name: text(raw["name"]),
    profile: text(raw["profile"]),
    is_real: raw["is_real"] === true,
    is_seen: raw["is_seen"] !== false,
    verbs,
    fields: list<Json>(raw["fields"]).filter(isObject).map(readField),
    inputs: Object.fromEntries(Object.entries(isObject(raw["inputs"]) ? raw["inputs"] : {}).map(([pin, field]) => [pin, text(field)])),
  };
}

function readField(raw: Json): FieldRow {
  return {
    name: text(raw["name"]),
    type: text(raw["type"]),
    unit: text(raw["unit"]),
    meaning: text(raw["meaning"]),
    is_settable: raw["is_settable"] === true,
    is_state: raw["is_state"] === true,
  };
}

function readParameters(raw: unknown): ParameterRow[] {
  return list<Json>(raw)
    .filter(isObject)
    .map((row) => ({ ...row, name: text(row["name"]), summary: text(row["summary"]) }) as ParameterRow);
}

function readFaultKind(raw: Json): FaultKindRow {
  return {
    name: text(raw["name"]),
    title: text(raw["title"]) || text(raw["name"]),
    layer: text(raw["layer"]),
    target: text(raw["target"]),
    on: text(raw["on"]),
    summary: text(raw["summary"]),
    is_once: raw["is_once"] === true,
    parameters: readParameters(raw["parameters"]),
  };
}

/** Decode a text frame. What is no message of the protocol is "unknown", never an exception. */
export function readText(frame: string): ServerMessage {
  let told: unknown;
  try {
    told = JSON.parse(frame);
  } catch {
    return { kind: "unknown" };
  }
  if (!isObject(told)) return { kind: "unknown" };
  if (isObject(told["hello"])) return { kind: "hello", hello: readHello(told["hello"]), isChange: false };
  if (isObject(told["changed"])) return { kind: "hello", hello: readHello(told["changed"]), isChange: true };
  if (isObject(told["closed"])) {
    const what = "watch" in told["closed"] ? "watch" : "terminal";
    return { kind: "closed", what, number: Number(told["closed"][what]), why: text(told["closed"]["why"]) };
  }
  if (isObject(told["taken"])) return { kind: "taken", terminal: Number(told["taken"]["terminal"]), bytes: Number(told["taken"]["bytes"]) };
  const id = told["id"];
  if (typeof id === "number" && isObject(told["error"])) {
    const error = told["error"];
    const refused = new Refused(text(error["code"]), text(error["message"]), list(error["problems"]));
    return { kind: "error", id, error: refused };
  }
  if (typeof id === "number" && "answer" in told) return { kind: "answer", id, answer: told["answer"] };
  if (typeof told["watch"] === "number") {
    const push: ServerMessage = { kind: "push", watch: told["watch"], lost: Number(told["lost"] ?? 0) };
    if (Array.isArray(told["items"])) push.items = told["items"];
    if ("value" in told) push.value = told["value"];
    return push;
  }
  return { kind: "unknown" };
}

/** Block of samples of a watch: `values` are rows of at_s and the fields. `lost`: samples since the beginning. */
export interface SampleBlock {
  kind: "samples";
  watch: number;
  lost: number;
  columns: number;
  rows: number;
  values: Float64Array;
}

export interface TerminalBytes {
  kind: "terminal";
  terminal: number;
  /** Simulated time; NaN: it was not told. */
  at_s: number;
  bytes: Uint8Array;
}

export type BinaryPart = SampleBlock | TerminalBytes;

/** Decode a binary message: blocks of samples one after the other, one for each watch, or bytes of a terminal. Null:
 * it is none, as where its length does not fit what it says. Little endian, as the computers of browsers are. */
export function readBinary(message: ArrayBuffer): BinaryPart[] | null {
  const head = new DataView(message);
  if (message.byteLength >= TERMINAL_HEAD && head.getUint8(0) === TERMINAL) {
    return [{ kind: "terminal", terminal: head.getUint32(4, true), at_s: NaN, bytes: new Uint8Array(message, TERMINAL_HEAD) }];
  }
  if (message.byteLength >= TIMED_HEAD && head.getUint8(0) === TIMED) {
    return [{ kind: "terminal", terminal: head.getUint32(4, true), at_s: head.getFloat64(8, true), bytes: new Uint8Array(message, TIMED_HEAD) }];
  }
  const blocks: SampleBlock[] = [];
  let at = 0;
  while (at < message.byteLength) {
    if (at + SAMPLES_HEAD > message.byteLength || head.getUint8(at) !== SAMPLES) return null;
    const columns = 1 + head.getUint8(at + 1);
    const rows = head.getUint32(at + 12, true);
    const begin = at + SAMPLES_HEAD;
    const end = begin + rows * columns * 8;
    if (end > message.byteLength) return null;
    const values = new Float64Array(message, begin, rows * columns);
    blocks.push({ kind: "samples", watch: head.getUint32(at + 4, true), lost: head.getUint32(at + 8, true), columns, rows, values });
    at = end;
  }
  return blocks.length ? blocks : null;
}

/** Encode bytes typed at a terminal as messages of at most so many bytes. */
export function* terminalFrames(terminal: number, bytes: Uint8Array, most_bytes: number): Generator<Uint8Array<ArrayBuffer>> {
  const most = Math.max(most_bytes - TERMINAL_HEAD, 1);
  for (let at = 0; at < bytes.length; at += most) yield terminalFrame(terminal, bytes.subarray(at, at + most));
}

/** Encode bytes typed at a terminal. */
export function terminalFrame(terminal: number, bytes: Uint8Array): Uint8Array<ArrayBuffer> {
  const frame = new Uint8Array(TERMINAL_HEAD + bytes.length);
  frame[0] = TERMINAL;
  new DataView(frame.buffer).setUint32(4, terminal, true);
  frame.set(bytes, TERMINAL_HEAD);
  return frame;
}
