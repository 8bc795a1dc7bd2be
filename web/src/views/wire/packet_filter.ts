/** The filter of packets: its words, and what completes them. Pure. */

import { conversationOf, nodeOf, sdoNode, unitOf, type WireKind } from "./conversation";
import { pairOf } from "./conversation";
import { bytesOf, type WirePacket } from "./packet_log";

export type PacketTest = (packet: WirePacket) => boolean;

/** Words of the filter with what they mean, for a kind of wire. */
export function filterWords(kind: WireKind): [word: string, meaning: string][] {
  const own: Record<WireKind, [string, string][]> = {
    can: [
      ["id:585", "this identifier"],
      ["node:5", "identifiers of CANopen node 5"],
      ["sdo:5", "SDO requests and answers of node 5"],
      ["by:m1.canopen", "what this node sent"],
    ],
    modbus: [
      ["unit:2", "questions to unit 2 and its answers"],
      ["fn:3", "function 3"],
      ["by:bus0.master", "what this station sent"],
    ],
    sac: [
      ["from:1", "packets of address 1"],
      ["to:85", "packets to address 85"],
      ["talk:1+85", "what the two say to each other"],
      ["by:s1.network", "what this station sent"],
    ],
    lines: [["by:arm.port", "what this station sent"]],
  };
  return [
    ["m3000", "this text is in its meaning"],
    ...own[kind],
    ["hex:0255", "these bytes"],
    ["error", "something was wrong"],
    ["error:crc", "this was wrong"],
    ["-error", "a minus excludes"],
  ];
}

export function filterHelp(kind: WireKind): string {
  return filterWords(kind)
    .map(([word, meaning]) => `${word}: ${meaning}`)
    .join("\n");
}

/** Make a test of a filter's words; all of them must hold. */
export function packetFilter(text: string): PacketTest {
  const tests = text.trim().toLowerCase().split(/\s+/).filter(Boolean).map(wordTest);
  return (packet) => tests.every((test) => test(packet));
}

const KEYS: Record<string, (packet: WirePacket, value: string) => boolean> = {
  from: (packet, value) => packet.from.toLowerCase() === value,
  to: (packet, value) => packet.to.toLowerCase() === value,
  by: (packet, value) => packet.by.some((each) => each.toLowerCase() === value),
  id: (packet, value) => packet.id.toLowerCase() === value,
  node: (packet, value) => String(nodeOf(packet)) === value,
  sdo: (packet, value) => String(sdoNode(packet)) === value,
  unit: (packet, value) => unitOf(packet) === value,
  fn: (packet, value) => bytesOf(packet) > 1 && String(Number.parseInt(packet.hex.slice(2, 4), 16) & 0x7f) === value,
  talk: (packet, value) => pairOf(packet).toLowerCase() === value,
  error: (packet, value) => packet.error?.toLowerCase().includes(value) ?? false,
};

function wordTest(word: string): PacketTest {
  if (word.startsWith("-") && word.length > 1) {
    const test = wordTest(word.slice(1));
    return (packet) => !test(packet);
  }
  const [, key, value] = /^([a-z]+):(.*)$/.exec(word) ?? [];
  if (key === "hex") {
    const digits = value!.replace(/[^0-9a-f]/g, "");
    return (packet) => packet.hex.toLowerCase().includes(digits);
  }
  if (key !== undefined && Object.hasOwn(KEYS, key)) return (packet) => KEYS[key]!(packet, value!);
  if (word === "error") return (packet) => packet.error !== null;
  return (packet) => `${packet.id} ${packet.from} ${packet.to} ${packet.by.join(" ")} ${packet.text} ${packet.error ?? ""}`.toLowerCase().includes(word);
}

const MOST_ENDS = 40;

/** Whole texts that the last word of a filter may become, by what was on the wire. */
export function completions(text: string, kind: WireKind, seen: readonly WirePacket[]): string[] {
  const [, before, minus, word] = /^(.*?)(-?)([^\s]*)$/s.exec(text)!;
  const found = new Set<string>();
  for (const packet of seen) {
    const talk = conversationOf(kind, packet);
    if (talk) found.add(talk);
    for (const by of packet.by) found.add(`by:${by.toLowerCase()}`);
    if (kind === "can" && nodeOf(packet)) found.add(`node:${nodeOf(packet)}`).add(`id:${packet.id.toLowerCase()}`);
    if (kind === "modbus" && bytesOf(packet) > 1) found.add(`fn:${Number.parseInt(packet.hex.slice(2, 4), 16) & 0x7f}`);
    if (kind === "sac" && packet.from && packet.to) found.add(`from:${packet.from}`).add(`to:${packet.to}`);
    if (packet.error) found.add("error").add(`error:${packet.error.toLowerCase().split(/\s/)[0]!}`);
  }
  const ends = [...found]
    .filter((each) => each.startsWith(word!.toLowerCase()) && each !== word)
    .sort((one, other) => one.localeCompare(other, "en", { numeric: true }));
  return ends.slice(0, MOST_ENDS).map((each) => `${before}${minus}${each}`);
}

/** A filter with a word more, or without it where it has it. */
export function withWord(text: string, word: string): string {
  const words = text.split(/\s+/).filter(Boolean);
  return (words.includes(word) ? words.filter((each) => each !== word) : [...words, word]).join(" ");
}
