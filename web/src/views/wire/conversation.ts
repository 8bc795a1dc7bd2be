/** Kinds of wire, and which packets belong together on each. Pure. */

import type { WirePacket } from "./packet_log";

/** What the packets of a wire are: it decides on columns, conversations and statistics. */
export type WireKind = "can" | "modbus" | "sac" | "lines";

export function kindOf(isBus: boolean, framing: string | undefined): WireKind {
  if (isBus) return "can";
  return framing === "sac" ? "sac" : framing === "modbus_rtu" ? "modbus" : "lines";
}

const SDO_ANSWER = 0x580;
const SDO_REQUEST = 0x600;
const NODE_BITS = 0x7f;

/** CANopen node whose identifier this is; 0: it is of none. */
export function nodeOf(packet: WirePacket): number {
  return packet.id.length === 3 ? Number.parseInt(packet.id, 16) & NODE_BITS : 0;
}

/** Node whose SDO dialogue a frame is of; 0: it is of none. */
export function sdoNode(packet: WirePacket): number {
  const service = packet.id.length === 3 ? Number.parseInt(packet.id, 16) & ~NODE_BITS : 0;
  return service === SDO_ANSWER || service === SDO_REQUEST ? nodeOf(packet) : 0;
}

/** Modbus unit that a frame is to or from; empty: nobody knows. */
export function unitOf(packet: WirePacket): string {
  return packet.to || (/^\d+$/.test(packet.from) ? packet.from : "");
}

/** Word of the filter that a packet's whole conversation has; empty: it is of none. */
export function conversationOf(kind: WireKind, packet: WirePacket): string {
  if (kind === "can") return sdoNode(packet) ? `sdo:${sdoNode(packet)}` : packet.id ? `id:${packet.id.toLowerCase()}` : "";
  if (kind === "modbus") return unitOf(packet) ? `unit:${unitOf(packet)}` : "";
  if (kind === "sac" && packet.from && packet.to) return `talk:${pairOf(packet)}`;
  return packet.by.length === 1 ? `by:${packet.by[0]!.toLowerCase()}` : "";
}

/** The two that talk, whoever of them speaks. */
export function pairOf(packet: WirePacket): string {
  return [packet.from, packet.to].sort((one, other) => one.localeCompare(other, "en", { numeric: true })).join("+");
}

/** Adds to each packet how long after the one before it of its conversation it came. They come in their order. */
export class Conversations {
  private readonly last_s = new Map<string, number>();

  constructor(private readonly kind: WireKind) {}

  placed(packet: WirePacket): WirePacket {
    const key = conversationOf(this.kind, packet);
    if (!key || packet.isUnfinished) return packet;
    const before_s = this.last_s.get(key);
    this.last_s.set(key, packet.at_s);
    return before_s === undefined ? packet : { ...packet, apart_s: packet.at_s - before_s };
  }
}

/** Whether a packet wants an answer, and which conversation it is of. */
export function isQuestion(kind: WireKind, packet: WirePacket): boolean {
  if (packet.error !== null) return false;
  if (kind === "modbus") return packet.to !== "" && packet.to !== "all";
  if (kind === "can") return sdoNode(packet) > 0 && (Number.parseInt(packet.id, 16) & ~NODE_BITS) === SDO_REQUEST;
  return kind === "sac" && packet.to !== "all" && packet.to !== "" && !/ (ACK|NAK)$/.test(packet.text);
}

/** Whether a packet answers a question of its conversation. */
export function isAnswer(kind: WireKind, question: WirePacket, packet: WirePacket): boolean {
  if (packet.error !== null) return false;
  if (kind === "sac") return packet.from === question.to && packet.to === question.from;
  return !isQuestion(kind, packet);
}

/** Whom statistics count a packet for. */
export function groupOf(kind: WireKind, packet: WirePacket): string {
  if (kind === "can") return packet.id;
  if (kind === "modbus") return unitOf(packet);
  if (kind === "sac") return packet.from && packet.to ? `${packet.from} → ${packet.to}` : "";
  return packet.by.join(" and ");
}
