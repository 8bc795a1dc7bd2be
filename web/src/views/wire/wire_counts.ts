/** What is counted of the packets of a wire, one after the other. Pure. */

import { conversationOf, groupOf, isAnswer, isQuestion, type WireKind } from "./conversation";
import { bytesOf, type WirePacket } from "./packet_log";

/** Answers from which on a usual time is known. */
const USUAL_AFTER = 8;
const LATE_TIMES = 2;
const LATE_LEAST_S = 0.001;

/** Mean, spread and bounds of times, without keeping them. */
export class Times {
  count = 0;
  mean_s = 0;
  least_s = Infinity;
  most_s = 0;
  private squares = 0;

  add(time_s: number): void {
    this.count += 1;
    const off_s = time_s - this.mean_s;
    this.mean_s += off_s / this.count;
    this.squares += off_s * (time_s - this.mean_s);
    this.least_s = Math.min(this.least_s, time_s);
    this.most_s = Math.max(this.most_s, time_s);
  }

  /** Standard deviation. */
  get spread_s(): number {
    return this.count > 1 ? Math.sqrt(this.squares / (this.count - 1)) : 0;
  }
}

/** Packets of an identifier, a unit, or a pair of addresses. */
export class GroupCounts {
  packets = 0;
  bytes = 0;
  errors = 0;
  /** Times from one packet, or question, to the next. */
  readonly period = new Times();
  readonly answers = new Times();
  /** Answers that took more than twice the usual time. */
  late = 0;
  /** Questions that the next one came before an answer. */
  unanswered = 0;
  last_s: number | undefined;

  constructor(readonly name: string) {}

  answered(time_s: number): void {
    const usual_s = this.answers.mean_s;
    if (this.answers.count >= USUAL_AFTER && time_s > LATE_TIMES * usual_s && time_s - usual_s > LATE_LEAST_S) this.late += 1;
    this.answers.add(time_s);
  }
}

export class WireCounts {
  packets = 0;
  bytes = 0;
  busy_s = 0;
  longest_s = 0;
  first_s: number | undefined;
  last_s = 0;
  readonly errors = new Map<string, number>();
  readonly groups = new Map<string, GroupCounts>();
  private readonly open = new Map<string, WirePacket>();

  constructor(private readonly kind: WireKind) {}

  get span_s(): number {
    return this.first_s === undefined ? 0 : this.last_s - this.first_s;
  }

  get bad(): number {
    let sum = 0;
    for (const count of this.errors.values()) sum += count;
    return sum;
  }

  add(packet: WirePacket): void {
    if (packet.isUnfinished) return; // what comes next has its bytes
    const size = bytesOf(packet);
    this.packets += packet.times;
    this.bytes += size;
    this.busy_s += packet.duration_s;
    if (packet.times === 1) this.longest_s = Math.max(this.longest_s, packet.duration_s);
    this.first_s ??= packet.at_s;
    this.last_s = Math.max(this.last_s, packet.at_s + packet.duration_s);
    if (packet.error !== null) this.errors.set(packet.error, (this.errors.get(packet.error) ?? 0) + packet.times);
    const name = groupOf(this.kind, packet);
    if (!name) return;
    const group = this.group(name);
    group.packets += packet.times;
    group.bytes += size;
    if (packet.error !== null) group.errors += packet.times;
    if (this.kind !== "modbus" || isQuestion(this.kind, packet)) {
      if (group.last_s !== undefined) group.period.add(packet.at_s - group.last_s);
      group.last_s = packet.at_s;
    }
    this.converse(packet);
  }

  private group(name: string): GroupCounts {
    let known = this.groups.get(name);
    if (!known) this.groups.set(name, (known = new GroupCounts(name)));
    return known;
  }

  private converse(packet: WirePacket): void {
    const key = conversationOf(this.kind, packet);
    const question = key ? this.open.get(key) : undefined;
    if (question && isAnswer(this.kind, question, packet)) {
      this.group(groupOf(this.kind, question)).answered(packet.at_s - question.at_s - question.duration_s);
      this.open.delete(key);
      return;
    }
    if (!key || !isQuestion(this.kind, packet)) return;
    if (question) this.group(groupOf(this.kind, question)).unanswered += 1;
    this.open.set(key, packet);
  }
}
