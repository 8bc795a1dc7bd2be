/** Columns of the list of packets, by the kind of wire. Pure. */

import { unitOf, type WireKind } from "./conversation";
import { bytesOf, type WirePacket } from "./packet_log";

export interface Column {
  readonly title: string;
  /** Class of its cells. */
  readonly look: string;
  text(packet: WirePacket): string;
}

const BY: Column = { title: "Sent by", look: "wide-only", text: (packet) => packet.by.join(" and ") || "?" };

/** Columns between the times and the meaning. */
const OWN: Record<WireKind, readonly Column[]> = {
  can: [
    { title: "ID", look: "mono", text: ({ id }) => id },
    { title: "DLC", look: "mono num wide-only", text: (packet) => (packet.id ? (packet.isRemote ? "R" : String(bytesOf(packet))) : "") },
    BY,
  ],
  modbus: [
    { title: "Unit", look: "mono num", text: unitOf },
    { title: "Function", look: "mono num wide-only", text: (packet) => functionOf(packet) },
    { title: "", look: "soft", text: (packet) => (packet.error !== null ? "" : packet.to ? "asks" : "answers") },
    BY,
  ],
  sac: [
    { title: "From", look: "mono num", text: (packet) => (/^\d+$/.test(packet.from) ? packet.from : "") },
    { title: "To", look: "mono num", text: ({ to }) => to },
    BY,
  ],
  lines: [BY],
};

export function columnsOf(kind: WireKind): readonly Column[] {
  return OWN[kind];
}

function functionOf(packet: WirePacket): string {
  if (packet.error !== null || bytesOf(packet) < 2) return "";
  return String(Number.parseInt(packet.hex.slice(2, 4), 16) & 0x7f);
}

/** Meaning without what other columns of the kind have. */
export function meaningOf(kind: WireKind, packet: WirePacket): string {
  const { text, error } = packet;
  if (text === error) return "";
  if (kind === "sac") return text.replace(/^\S+ -> \S+ /, "");
  if (kind === "modbus") return text.replace(/^(to|from) \S+: /, "");
  // Bytes of a line that nobody knows are told as digits and as characters: the digits have a column.
  return kind === "lines" ? text.replace(/^(?:[0-9a-f]{2} )*[0-9a-f]{2} {2}(?=.)/, "") : text;
}

/** Time as it is read fastest: 12.3 us, 4.56 ms, 1.234 s. */
export function timeText(time_s: number): string {
  const size_s = Math.abs(time_s);
  if (size_s < 0.0009995) return `${(time_s * 1e6).toFixed(size_s < 1e-5 ? 1 : 0)} µs`;
  if (size_s < 0.9995) return `${(time_s * 1e3).toPrecision(4)} ms`;
  return `${time_s.toFixed(3)} s`;
}
