/** What the bench needs to tell a packet's fields: the packet, and those before it that say what it answers. Pure. */

import { conversationOf, nodeOf, sdoNode, type WireKind } from "./conversation";
import { bytesOf, type WirePacket } from "./packet_log";
import type { PacketRows } from "./shown_packets";

/** Most packets that are sent along, and how far back they are looked for. */
const MOST = 200;
const BACK = 20_000;

/** Texts of the packets before, and of the packet itself, as the door takes them; empty: it has no bytes to tell of. */
export function fieldContext(kind: WireKind, log: PacketRows, place: number, packet: WirePacket): string[] {
  const own = textOf(kind, packet);
  if (!own) return [];
  const before: string[] = [];
  const most = kind === "can" ? MOST : kind === "modbus" ? 1 : 0;
  for (let at = place - 1; at >= 0 && at > place - BACK && before.length < most; at--) {
    const other = log.at(at)!;
    if (other.error === null && belongs(kind, packet, other)) before.push(textOf(kind, other));
  }
  return [...before.reverse().filter(Boolean), own];
}

/** SDOs say what a node's PDOs have, and a question what its answer is. */
function belongs(kind: WireKind, packet: WirePacket, other: WirePacket): boolean {
  if (kind === "can") return nodeOf(packet) > 0 && sdoNode(other) === nodeOf(packet);
  return conversationOf(kind, other) === conversationOf(kind, packet);
}

function textOf(kind: WireKind, packet: WirePacket): string {
  if (kind === "can") return packet.id ? `${packet.id}#${packet.isRemote ? "R" : packet.hex.toUpperCase()}` : "";
  return bytesOf(packet) ? `${packet.at_s} ${packet.hex}` : "";
}

/** Place of the innermost field that a byte is of; -1: of none. */
export function fieldAt(fields: readonly { begin: number; end: number; level: number }[], byte: number): number {
  let found = -1;
  fields.forEach(({ begin, end, level }, at) => {
    if (begin <= byte && byte < end && (found < 0 || level >= fields[found]!.level)) found = at;
  });
  return found;
}
