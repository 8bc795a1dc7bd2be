/** Packets of a log that a filter lets through, kept up to date without looking at all of them again. Pure. */

import { packetFilter } from "./packet_filter";
import type { PacketLog, WirePacket } from "./packet_log";

/** Rows of the list, by their place. */
export interface PacketRows {
  readonly length: number;
  at(index: number): WirePacket | undefined;
}

export class ShownPackets {
  private text: string | undefined;
  private found: WirePacket[] = [];
  private first = 0;
  private upTo = 0;

  constructor(private readonly log: PacketLog) {}

  /** Rows that a filter leaves; without one the log itself. */
  rows(text: string): PacketRows {
    const filter = text.trim();
    if (!filter) return this.log;
    if (filter !== this.text || this.upTo > this.log.count) {
      this.text = filter;
      this.found = [];
      this.first = this.upTo = 0;
    }
    this.follow(filter);
    const { found, first } = this;
    return { length: found.length - first, at: (index) => (index < 0 ? undefined : found[first + index]) };
  }

  private follow(filter: string): void {
    const { log } = this;
    // An unfinished packet goes when its bytes come again: the last one is looked at twice.
    while (this.found.length > this.first && this.found.at(-1)!.isUnfinished) this.upTo = Math.min(this.upTo, this.found.pop()!.number - 1);
    const passes = packetFilter(filter);
    const oldest = log.at(0)?.number ?? 0;
    for (let index = Math.max(this.upTo - oldest + 1, 0); index < log.length; index++) {
      const packet = log.at(index)!;
      if (passes(packet)) this.found.push(packet);
      if (!packet.isUnfinished) this.upTo = packet.number;
    }
    while (this.first < this.found.length && this.found[this.first]!.number < oldest) this.first += 1;
    if (this.first > 10_000) {
      this.found = this.found.slice(this.first);
      this.first = 0;
    }
  }
}

/** Place of a packet in rows by its number; -1: it is not there. */
export function placeOf(rows: PacketRows, number: number | undefined): number {
  if (number === undefined) return -1;
  let low = 0;
  let high = rows.length - 1;
  while (low <= high) {
    const middle = (low + high) >> 1;
    const at = rows.at(middle)!.number;
    if (at === number) return middle;
    if (at < number) low = middle + 1;
    else high = middle - 1;
  }
  return -1;
}
