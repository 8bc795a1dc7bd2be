/** CAN buses as the bench's status tells them: their speed, load, errors, and the controllers on them. Pure. */

export interface BusNodeStatus {
  readonly node: string;
  readonly sent: number;
  readonly heard: number;
  readonly transmit_errors: number;
  readonly receive_errors: number;
  readonly state: string;
}

export interface BusStatus {
  readonly bus: string;
  readonly bit_rate: number;
  readonly load_percent: number;
  readonly frames: number;
  readonly errors: readonly [string, number][];
  readonly nodes: readonly BusNodeStatus[];
  /** CANopen node id and NMT state by the name of the controller. */
  readonly drives: ReadonlyMap<string, { id: number; state: string }>;
}

type Told = Record<string, unknown>;

function told(raw: unknown): Told {
  return typeof raw === "object" && raw !== null && !Array.isArray(raw) ? (raw as Told) : {};
}

function count(raw: unknown): number {
  return typeof raw === "number" && Number.isFinite(raw) ? raw : 0;
}

/** Read `buses` of a status; what has another form than it should is left out. */
export function readBuses(raw: unknown): BusStatus[] {
  if (!Array.isArray(raw)) return [];
  return raw.map(told).flatMap((bus) => {
    if (typeof bus["bus"] !== "string") return [];
    return {
      bus: bus["bus"],
      bit_rate: count(bus["bit_rate"]),
      load_percent: count(bus["load_percent"]),
      frames: count(bus["frames"]),
      errors: Object.entries(told(bus["errors"])).map(([name, number]): [string, number] => [name, count(number)]),
      nodes: Object.entries(told(bus["nodes"])).map(([node, each]) => readNode(node, told(each))),
      drives: new Map(
        Object.entries(told(bus["drives"])).map(([name, each]) => [name, { id: count(told(each)["id"]), state: String(told(each)["state"] ?? "") }]),
      ),
    };
  });
}

function readNode(node: string, each: Told): BusNodeStatus {
  return {
    node,
    sent: count(each["sent"]),
    heard: count(each["heard"]),
    transmit_errors: count(each["transmit_errors"]),
    receive_errors: count(each["receive_errors"]),
    state: typeof each["state"] === "string" ? each["state"] : "",
  };
}
