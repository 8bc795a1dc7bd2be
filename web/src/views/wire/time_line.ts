/** Time line of a segment's last second: a lane for each that speaks, collisions across all. Without a screen. */

import { isCollision, type WirePacket } from "./packet_log";

export const SPAN_S = 1;

export interface Bar {
  readonly packet: WirePacket;
  readonly lane: number;
  /** Begin and end as parts of the span, 0 to 1. */
  readonly begin: number;
  readonly end: number;
}

/** Time in which several spoke. */
export interface Collision {
  readonly begin: number;
  readonly end: number;
}

export interface TimeLine {
  readonly lanes: readonly string[];
  readonly bars: readonly Bar[];
  readonly collisions: readonly Collision[];
}

/** Lay packets out over the span before `now_s`. A lane, once there, keeps its place: `known` are those of
 * before. */
export function timeLine(packets: readonly WirePacket[], now_s: number, known: readonly string[]): TimeLine {
  const from_s = now_s - SPAN_S;
  const place = (time_s: number) => Math.min(Math.max((time_s - from_s) / SPAN_S, 0), 1);
  const seen = packets.filter((packet) => packet.at_s + packet.duration_s > from_s && packet.at_s < now_s);
  const lanes = [...new Set([...known, ...seen.flatMap(speakers)])];
  const bars = seen.flatMap((packet) => {
    const begin = place(packet.at_s);
    const end = place(packet.at_s + packet.duration_s);
    return speakers(packet).map((name) => ({ packet, lane: lanes.indexOf(name), begin, end }));
  });
  return { lanes, bars, collisions: overlaps(bars) };
}

/** Who speaks: an unknown one where what was heard does not tell. */
function speakers(packet: WirePacket): readonly string[] {
  return packet.by.length ? packet.by : ["?"];
}

/** Times in which bars of different lanes overlap, or of which a packet says that it collided; joined. */
function overlaps(bars: readonly Bar[]): Collision[] {
  const found: Collision[] = [];
  const inTime = [...bars].sort((one, other) => one.begin - other.begin);
  inTime.forEach((bar, index) => {
    if (isCollision(bar.packet)) found.push({ begin: bar.begin, end: bar.end });
    for (let next = index + 1; next < inTime.length && inTime[next]!.begin < bar.end; next++) {
      const other = inTime[next]!;
      const end = Math.min(bar.end, other.end);
      if (other.lane !== bar.lane && end > other.begin) found.push({ begin: other.begin, end });
    }
  });
  return joined(found);
}

function joined(spans: Collision[]): Collision[] {
  const result: Collision[] = [];
  for (const span of spans.sort((one, other) => one.begin - other.begin)) {
    const last = result.at(-1);
    if (last && span.begin <= last.end) result[result.length - 1] = { begin: last.begin, end: Math.max(last.end, span.end) };
    else result.push(span);
  }
  return result;
}

/** Clock of a bench between two of its messages: it goes on at the speed that was seen, and never back. */
export class BenchClock {
  private anchor_s = 0;
  private anchor_ms = 0;
  private speed = 1;
  private latest_s = 0;

  /** Take a time that the bench told, at a wall time. */
  tell(time_s: number, wall_ms: number, speed = this.speed): void {
    this.speed = speed;
    if (time_s < this.now_s(wall_ms) - 1) this.latest_s = 0; // another bench, or begun again
    this.anchor_s = time_s;
    this.anchor_ms = wall_ms;
  }

  now_s(wall_ms: number): number {
    const time_s = this.anchor_s + ((wall_ms - this.anchor_ms) / 1000) * this.speed;
    this.latest_s = Math.max(this.latest_s, time_s);
    return this.latest_s;
  }
}
