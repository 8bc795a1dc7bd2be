/** Packets of segments and frames of buses as they come, kept while the page is open. */

import { signal } from "@preact/signals";
import { type Kept, keptText } from "../../kept";
import type { WatchHandle } from "../../net/channels";
import { hello, link, status } from "../../store";
import { Conversations, kindOf, type WireKind } from "./conversation";
import { PacketLog, readPacket, type WirePacket } from "./packet_log";
import { ShownPackets, type PacketRows } from "./shown_packets";
import { BenchClock, type LaneWindow, SPAN_S } from "./time_line";
import { WireCounts } from "./wire_counts";

/** Wire of the bench that can be looked at. */
export interface WirePlace {
  readonly name: string;
  readonly kind: "segment" | "bus";
}

/** What the list shows: the log with what was counted of it. */
class Source {
  readonly shown: ShownPackets;
  constructor(
    readonly log: PacketLog,
    readonly counts: WireCounts,
    /** Present of the time that it shows; undefined: the bench's. */
    readonly now_s?: number,
  ) {
    this.shown = new ShownPackets(log);
  }
}

export class WireFeed {
  readonly kind: WireKind;
  readonly clock = new BenchClock();
  /** Counts up whenever there is something new to draw. */
  readonly news = signal(0);
  readonly lost = signal(0);
  readonly filter: Kept<string>;
  /** Packets as they were when the list was paused, or those of the past that the page shows. */
  readonly paused = signal<Source | undefined>(undefined);
  readonly refused = signal("");
  readonly window = signal<LaneWindow>({ span_s: SPAN_S, end_s: null });
  /** Packet that times are told from. */
  readonly marked = signal<WirePacket | undefined>(undefined);
  lanes: readonly string[] = [];
  private live: Source;
  private conversations: Conversations;
  private handle: WatchHandle | undefined;
  private users = 0;

  constructor(readonly place: WirePlace) {
    this.kind = kindOf(place.kind === "bus", hello.peek()?.lines.get(place.name)?.framing);
    this.filter = keptText(`wire.${place.kind}.${place.name}.filter`);
    this.live = new Source(new PacketLog(), new WireCounts(this.kind));
    this.conversations = new Conversations(this.kind);
  }

  /** Watch the wire while somebody looks at it. */
  attach(): () => void {
    this.users += 1;
    this.handle ??= link.watch(
      { what: this.place.kind === "segment" ? "packets" : "frames", target: this.place.name },
      {
        items: (items, lost) => this.take(items, lost),
        refused: (error) => (this.refused.value = error.message),
        again: () => (this.refused.value = ""),
      },
    );
    return () => {
      this.users -= 1;
      if (this.users) return;
      this.handle?.close();
      this.handle = undefined;
    };
  }

  /** Number of the watch at the door; 0: there is none now. */
  get watch(): number {
    return this.handle?.number ?? 0;
  }

  private take(items: unknown[], lost: number): void {
    const { log, counts } = this.live;
    for (const item of items) {
      log.dropUnfinished();
      const packet = readPacket(item, log.count + 1);
      if (!packet) continue;
      const placed = this.conversations.placed(packet);
      log.add(placed);
      counts.add(placed);
    }
    this.lost.value = lost;
    this.news.value += 1;
  }

  /** Bench's time of now, between its messages too. */
  now_s(): number {
    const wall_ms = performance.now();
    const told = status.peek();
    if (told !== this.told) {
      this.told = told;
      this.clock.tell((told.sim_ns ?? 0) / 1e9, wall_ms, told.speed && told.speed > 0 ? told.speed : 1);
    }
    return this.clock.now_s(wall_ms);
  }

  private told: unknown;

  get log(): PacketLog {
    return this.live.log;
  }

  /** What is looked at: what passes, or what was paused. */
  get source(): Source {
    return this.paused.value ?? this.live;
  }

  rows(): PacketRows {
    return this.source.shown.rows(this.filter.value);
  }

  setPaused(isPaused: boolean): void {
    if (!isPaused) this.paused.value = undefined;
    else this.pause(this.live.log.all(), this.now_s());
  }

  /** Show these packets, and nothing that comes. */
  pause(packets: readonly WirePacket[], now_s: number): void {
    const log = new PacketLog();
    const counts = new WireCounts(this.kind);
    for (const packet of packets) {
      log.add(packet);
      counts.add(packet);
    }
    this.paused.value = new Source(log, counts, now_s);
  }

  /** Show packets of the past as they were at a time. */
  showPast(items: readonly unknown[], at_s: number): void {
    const conversations = new Conversations(this.kind);
    const packets = items.map((item, at) => readPacket(item, at + 1)).filter((packet) => packet !== undefined);
    this.pause(
      packets.map((packet) => conversations.placed(packet)),
      at_s,
    );
  }

  clear(): void {
    this.live = new Source(new PacketLog(), new WireCounts(this.kind));
    this.conversations = new Conversations(this.kind);
    this.marked.value = undefined;
    if (this.paused.value) this.setPaused(true);
    this.news.value += 1;
  }
}

const feeds = new Map<string, WireFeed>();

export function wireFeed(place: WirePlace): WireFeed {
  const key = `${place.kind} ${place.name} ${hello.peek()?.lines.get(place.name)?.framing ?? ""}`;
  const known = feeds.get(key) ?? new WireFeed(place);
  feeds.set(key, known);
  return known;
}
