/** Packets of a segment as they passed: a bounded log, its filter, and what is counted. Without a screen. */

/** Most packets that are kept, and shown, and that an export has. */
export const KEPT = 100_000;

/** Packet of a segment or frame of a bus, as the door tells it. `error`: null, or what was wrong. */
export interface WirePacket {
  readonly number: number;
  readonly at_s: number;
  readonly from: string;
  readonly to: string;
  /** Stations that drove the wire: several in a collision; none where nobody can tell. */
  readonly by: readonly string[];
  readonly hex: string;
  readonly text: string;
  readonly error: string | null;
  readonly duration_s: number;
  /** Number of equal errors that it stands for; 1: it is one. */
  readonly times: number;
  /** It has begun and does not go on; what comes next has its bytes, or takes its place. */
  readonly isUnfinished: boolean;
  /** Identifier of a CAN frame, as `585` or `0000CAFE`; empty: it is none. */
  readonly id: string;
  /** The frame asks for data, and has none. */
  readonly isRemote: boolean;
  /** Time since the packet before it of the same conversation; null: it is the first. */
  readonly apart_s: number | null;
}

/** Read an item of a packets watch; undefined: it is none. */
export function readPacket(item: unknown, number: number): WirePacket | undefined {
  if (typeof item !== "object" || item === null) return undefined;
  const told = item as Record<string, unknown>;
  const at_s = Number(told["at_s"]);
  if (!Number.isFinite(at_s)) return undefined;
  const duration_s = Number(told["duration_s"] ?? 0);
  const error = told["error"] === null || told["error"] === undefined ? null : textOf(told["error"]) || "error";
  const frame = textOf(told["frame"]);
  const by = drivers(told, error);
  return {
    number,
    at_s,
    from: textOf(told["from"]) || by.join(" and "),
    to: textOf(told["to"]),
    by,
    hex: textOf(told["hex"]),
    text: textOf(told["text"]),
    error,
    duration_s: Number.isFinite(duration_s) && duration_s > 0 ? duration_s : 0,
    times: Math.max(Math.round(Number(told["times"] ?? 1)) || 1, 1),
    isUnfinished: told["is_unfinished"] === true,
    id: frame.split("#")[0]!,
    isRemote: frame.includes("#R"),
    apart_s: null,
  };
}

const COLLISION = /^collision of (.+)$/;

/** Whether several stations spoke at once. */
export function isCollision(packet: WirePacket): boolean {
  return packet.error?.startsWith("collision") ?? false;
}

/** Stations that drove the wire: of a collision all, else the one that sent. */
function drivers(told: Record<string, unknown>, error: string | null): string[] {
  const several = COLLISION.exec(error ?? "")?.[1];
  if (several) return several.split(" and ");
  const [sender] = textOf(told["by"]).split(" ");
  return sender ? [sender] : told["from"] === null || told["from"] === undefined ? [] : [textOf(told["from"])];
}

function textOf(value: unknown): string {
  return value === null || value === undefined ? "" : String(value);
}

export function bytesOf(packet: WirePacket): number {
  return Math.floor(packet.hex.replace(/[^0-9a-f]/gi, "").length / 2);
}

/** The last packets, oldest first. Appending costs no copy: what is over is cut off in large pieces. */
export class PacketLog {
  private kept: WirePacket[] = [];
  private first = 0;
  /** Number of packets since the log began, or since it was cleared. */
  count = 0;

  constructor(private readonly most = KEPT) {}

  get length(): number {
    return this.kept.length - this.first;
  }

  /** Packet by its place, 0 the oldest. */
  at(index: number): WirePacket | undefined {
    return index < 0 ? undefined : this.kept[this.first + index];
  }

  add(packet: WirePacket): void {
    this.count += 1;
    this.kept.push(packet);
    if (this.length <= this.most) return;
    this.first += 1;
    if (this.first <= this.most / 4) return;
    this.kept = this.kept.slice(this.first);
    this.first = 0;
  }

  /** Take the last packet out if it is unfinished: it goes on. */
  dropUnfinished(): void {
    if (!this.at(this.length - 1)?.isUnfinished) return;
    this.kept.pop();
    this.count -= 1;
  }

  clear(): void {
    this.kept = [];
    this.first = 0;
    this.count = 0;
  }

  all(): WirePacket[] {
    return this.kept.slice(this.first);
  }

  /** Packets that were on the wire in a time, oldest first. */
  between(from_s: number, to_s: number): WirePacket[] {
    const found: WirePacket[] = [];
    for (let index = this.placeAfter(to_s) - 1; index >= 0; index--) {
      const packet = this.at(index)!;
      if (packet.at_s < from_s - LONGEST_S) break;
      if (packet.at_s + packet.duration_s > from_s) found.push(packet);
    }
    return found.reverse();
  }

  /** Place behind the last packet that began before a time. */
  private placeAfter(time_s: number): number {
    let low = 0;
    let high = this.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.at(middle)!.at_s < time_s) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}

/** Time that no packet lasts longer than. */
const LONGEST_S = 5;

/** Part of a time in which the wire was busy, 0 to 1. Packets over each other count once. */
export function load(packets: readonly WirePacket[], from_s: number, to_s: number): number {
  if (to_s <= from_s) return 0;
  let busy_s = 0;
  let until_s = from_s;
  for (const packet of [...packets].sort((one, other) => one.at_s - other.at_s)) {
    const begins_s = Math.max(packet.at_s, until_s);
    const ends_s = Math.min(packet.at_s + packet.duration_s, to_s);
    if (ends_s > begins_s) {
      busy_s += ends_s - begins_s;
      until_s = ends_s;
    }
  }
  return busy_s / (to_s - from_s);
}
