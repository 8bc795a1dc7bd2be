/** Packets of segments and frames of buses as they come, kept while the page is open. */

import { signal } from "@preact/signals";
import { type Kept, keptText } from "../../kept";
import type { WatchHandle } from "../../net/channels";
import { link, status } from "../../store";
import { packetFilter, PacketLog, readPacket, type WirePacket } from "./packet_log";
import { BenchClock } from "./time_line";

/** Wire of the bench that can be looked at. */
export interface WirePlace {
  readonly name: string;
  readonly kind: "segment" | "bus";
}

export class WireFeed {
  readonly log = new PacketLog();
  readonly clock = new BenchClock();
  /** Counts up whenever there is something new to draw. */
  readonly news = signal(0);
  readonly lost = signal(0);
  readonly filter: Kept<string>;
  /** Packets as they were when the list was paused. */
  readonly paused = signal<readonly WirePacket[] | undefined>(undefined);
  readonly refused = signal("");
  lanes: readonly string[] = [];
  private handle: WatchHandle | undefined;
  private users = 0;

  constructor(readonly place: WirePlace) {
    this.filter = keptText(`wire.${place.kind}.${place.name}.filter`);
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
    for (const item of items) {
      this.log.dropUnfinished();
      const packet = readPacket(item, this.log.count + 1);
      if (packet) this.log.add(packet);
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

  get shown(): WirePacket[] {
    const packets = this.paused.value ?? this.log.all();
    const text = this.filter.value.trim();
    return text ? packets.filter(packetFilter(text)) : [...packets];
  }

  setPaused(isPaused: boolean): void {
    this.paused.value = isPaused ? this.log.all() : undefined;
  }

  clear(): void {
    this.log.clear();
    if (this.paused.value) this.paused.value = [];
    this.news.value += 1;
  }
}

const feeds = new Map<string, WireFeed>();

export function wireFeed(place: WirePlace): WireFeed {
  const key = `${place.kind} ${place.name}`;
  const known = feeds.get(key) ?? new WireFeed(place);
  feeds.set(key, known);
  return known;
}
