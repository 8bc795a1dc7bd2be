/** Time line of a wire: a lane for each that speaks, collisions across all. Without a screen. */

import { niceStep } from "../../model/decimate";
import { isCollision, type WirePacket } from "./packet_log";

export const SPAN_S = 1;
const LEAST_SPAN_S = 0.0005;
const MOST_SPAN_S = 600;

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

/** Lay packets out over a span. A lane, once there, keeps its place: `known` are those of before. */
export function timeLine(packets: readonly WirePacket[], to_s: number, known: readonly string[], span_s = SPAN_S): TimeLine {
  const from_s = to_s - span_s;
  const place = (time_s: number) => Math.min(Math.max((time_s - from_s) / span_s, 0), 1);
  const seen = packets.filter((packet) => packet.at_s + packet.duration_s > from_s && packet.at_s < to_s);
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

/** Part of the time that the lanes show. `end_s`: null, it goes with the present. */
export interface LaneWindow {
  readonly span_s: number;
  readonly end_s: number | null;
}

/** The window a number of times as long, around a place in it (0 its begin, 1 its end). The present stays where it is. */
export function zoomed(window: LaneWindow, times: number, at = 1): LaneWindow {
  const span_s = Math.min(Math.max(window.span_s * times, LEAST_SPAN_S), MOST_SPAN_S);
  if (window.end_s === null) return { span_s, end_s: null };
  const fixed_s = window.end_s - window.span_s * (1 - at);
  return { span_s, end_s: fixed_s + span_s * (1 - at) };
}

/** The window moved by a part of its span, between the first packet and the present. */
export function moved(window: LaneWindow, parts: number, now_s: number, first_s: number): LaneWindow {
  const end_s = (window.end_s ?? now_s) + parts * window.span_s;
  if (end_s >= now_s) return { span_s: window.span_s, end_s: null };
  return { span_s: window.span_s, end_s: Math.max(end_s, Math.min(first_s + window.span_s * 0.9, now_s)) };
}

/** Times of a scale's marks: a round step, at most so many. */
export function marksOf(from_s: number, to_s: number, most: number): { times_s: number[]; step_s: number } {
  const step_s = niceStep((to_s - from_s) / Math.max(most, 1));
  const times_s: number[] = [];
  for (let mark = Math.ceil(from_s / step_s - 1e-6); mark * step_s <= to_s + step_s * 1e-6; mark++) times_s.push(mark * step_s);
  return { times_s, step_s };
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
