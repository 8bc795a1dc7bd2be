/** Packets of a segment as they passed: a bounded log, its filter, and what is counted. Without a screen. */

/** Most packets that are kept, and shown, and that an export has. */
export const KEPT = 10_000;

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
  /** It has begun and does not go on; what comes next has its bytes, or takes its place. */
  readonly isUnfinished: boolean;
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
  const text = textOf(told["text"]);
  const by = drivers(told, error);
  return {
    number,
    at_s,
    from: textOf(told["from"]) || by.join(" and "),
    to: textOf(told["to"]),
    by,
    hex: textOf(told["hex"]),
    text: frame && frame !== text ? `${frame}  ${text}`.trim() : text,
    error,
    duration_s: Number.isFinite(duration_s) && duration_s > 0 ? duration_s : 0,
    isUnfinished: told["is_unfinished"] === true,
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

/** The last packets, oldest first. A new one takes the place of the oldest; appending costs no copy. */
export class PacketLog {
  private readonly ring: WirePacket[] = [];
  private first = 0;
  /** Number of packets since the log began, or since it was cleared. */
  count = 0;

  constructor(private readonly most = KEPT) {}

  get length(): number {
    return this.ring.length;
  }

  /** Packet by its place, 0 the oldest. */
  at(index: number): WirePacket | undefined {
    return index < 0 || index >= this.ring.length ? undefined : this.ring[(this.first + index) % this.ring.length];
  }

  add(packet: WirePacket): void {
    this.count += 1;
    if (this.ring.length < this.most) {
      this.ring.push(packet);
      return;
    }
    this.ring[this.first] = packet;
    this.first = (this.first + 1) % this.most;
  }

  /** Take the last packet out if it is unfinished: it goes on. */
  dropUnfinished(): void {
    const last = this.at(this.length - 1);
    if (!last?.isUnfinished) return;
    const kept = this.all().slice(0, -1);
    this.ring.length = this.first = 0;
    this.ring.push(...kept);
    this.count -= 1;
  }

  clear(): void {
    this.ring.length = 0;
    this.first = 0;
    this.count = 0;
  }

  all(): WirePacket[] {
    return [...this.ring.slice(this.first), ...this.ring.slice(0, this.first)];
  }

  /** Packets that were on the wire after a time, oldest first. */
  since(time_s: number): WirePacket[] {
    const found: WirePacket[] = [];
    for (let index = this.length - 1; index >= 0; index--) {
      const packet = this.at(index)!;
      if (packet.at_s < time_s - LONGEST_S) break;
      if (packet.at_s + packet.duration_s > time_s) found.push(packet);
    }
    return found.reverse();
  }
}

/** Time that no packet lasts longer than. */
const LONGEST_S = 5;

// ---- filter ----

export type PacketTest = (packet: WirePacket) => boolean;

export const FILTER_HELP = "Words that must be there: m3000 · from:s1 · to:85 · hex:0255 · error · error:crc · a minus before a word excludes it";

/** Make a test of a filter's words; all of them must hold. */
export function packetFilter(text: string): PacketTest {
  const tests = text.trim().toLowerCase().split(/\s+/).filter(Boolean).map(wordTest);
  return (packet) => tests.every((test) => test(packet));
}

function wordTest(word: string): PacketTest {
  if (word.startsWith("-") && word.length > 1) {
    const test = wordTest(word.slice(1));
    return (packet) => !test(packet);
  }
  const [, key, value] = /^(from|to|hex|error):(.*)$/.exec(word) ?? [];
  switch (key) {
    case "from":
    case "to":
      return (packet) => packet[key].toLowerCase() === value;
    case "hex": {
      const digits = value!.replace(/[^0-9a-f]/g, "");
      return (packet) =>
        packet.hex
          .toLowerCase()
          .replace(/[^0-9a-f]/g, "")
          .includes(digits);
    }
    case "error":
      return (packet) => packet.error?.toLowerCase().includes(value!) ?? false;
  }
  if (word === "error") return (packet) => packet.error !== null;
  return (packet) => `${packet.from} ${packet.to} ${packet.text} ${packet.error ?? ""}`.toLowerCase().includes(word);
}

// ---- load ----

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

// ---- statistics ----

export interface Talk {
  readonly from: string;
  readonly to: string;
  packets: number;
  bytes: number;
  errors: number;
}

export interface Statistics {
  readonly packets: number;
  readonly bytes: number;
  readonly errors: ReadonlyMap<string, number>;
  readonly talks: readonly Talk[];
  readonly span_s: number;
  readonly mean_duration_s: number;
  readonly longest_s: number;
}

/** Count packets, by who speaks to whom and by what went wrong. */
export function statistics(packets: readonly WirePacket[]): Statistics {
  const talks = new Map<string, Talk>();
  const errors = new Map<string, number>();
  let bytes = 0;
  let duration_s = 0;
  let longest_s = 0;
  for (const packet of packets) {
    const key = JSON.stringify([packet.from, packet.to]);
    const talk = talks.get(key) ?? { from: packet.from, to: packet.to, packets: 0, bytes: 0, errors: 0 };
    talks.set(key, talk);
    const size = bytesOf(packet);
    bytes += size;
    talk.packets += 1;
    talk.bytes += size;
    duration_s += packet.duration_s;
    longest_s = Math.max(longest_s, packet.duration_s);
    if (packet.error !== null) {
      talk.errors += 1;
      errors.set(packet.error, (errors.get(packet.error) ?? 0) + 1);
    }
  }
  const first = packets[0];
  const last = packets.at(-1);
  return {
    packets: packets.length,
    bytes,
    errors,
    talks: [...talks.values()].sort((one, other) => other.packets - one.packets),
    span_s: first && last ? last.at_s + last.duration_s - first.at_s : 0,
    mean_duration_s: packets.length ? duration_s / packets.length : 0,
    longest_s,
  };
}
