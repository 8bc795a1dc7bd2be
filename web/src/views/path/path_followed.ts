/** Path that the axes follow while a drawing runs, from samples of the bench; and its distance from the one asked
 * for. It goes on while other views are looked at. */

import { effect, signal } from "@preact/signals";
import type { Drawing } from "../../model/drawing";
import { lineAt, partOf, pointsOf } from "../../model/drawing";
import { PathDeviation } from "../../model/path_deviation";
import type { WatchHandle } from "../../net/channels";
import { devices, link } from "../../store";
import { drawing, run } from "./path_state";

const RATE_HZ = 200;
const MOST_POINTS = 200_000;
const SAME_s = 1e-4;
/** A run that is seen so early is seen whole: its axes have hardly moved. */
const BEGINNING_NS = 3e8;

/** Places of all axes, one point after the other. */
export class Followed {
  places = new Float32Array(4096);
  count = 0;
  /** Grows with every point, and never falls: what is drawn knows what is new. */
  changes = 0;

  constructor(readonly axes: number) {}

  add(place: ArrayLike<number>): void {
    if (this.count >= MOST_POINTS) this.thin();
    if ((this.count + 1) * this.axes > this.places.length) {
      const wider = new Float32Array(this.places.length * 2);
      wider.set(this.places);
      this.places = wider;
    }
    for (let axis = 0; axis < this.axes; axis++) this.places[this.count * this.axes + axis] = place[axis]!;
    this.count++;
    this.changes++;
  }

  /** Keep every second point. */
  private thin(): void {
    const { axes } = this;
    for (let point = 0; point * 2 < this.count; point++) {
      for (let axis = 0; axis < axes; axis++) this.places[point * axes + axis] = this.places[point * 2 * axes + axis]!;
    }
    this.count = Math.ceil(this.count / 2);
  }
}

export const followed = signal<Followed | null>(null);
/** Largest distance from the path asked for, and the last one; null: nothing was followed yet. */
export const deviation = signal<{ largest: number; now: number } | null>(null);
export const isSeenWhole = signal(true);
export const whyNotSeen = signal("");

/** Signals that tell where an axis stands by its board's zero, in which set-points are; `hil zero` moves the shaft's. */
function boardAngle(axis: string): string[] {
  const names = (devices.peek().get(axis)?.fields ?? []).map((field) => field.name);
  return ["yw", "commanded_deg", "to_be_deg"].filter((name) => names.includes(name)).slice(0, 1);
}

class Following {
  /** Board's angle less the shaft's, by axis, as the first samples have them. */
  private readonly shifts_deg: (number | undefined)[] = [];
  private readonly waiting: Float64Array[][];
  private readonly watches: WatchHandle[];
  private readonly off: PathDeviation;
  private readonly place: Float64Array;

  constructor(
    private readonly made: Drawing,
    private readonly into: Followed,
    from: [number, number],
  ) {
    const { axes } = made;
    this.off = new PathDeviation(made.places, axes.length, ...from);
    this.off.largest = deviation.peek()?.largest ?? 0;
    this.place = new Float64Array(axes.length);
    this.waiting = axes.map(() => []);
    this.watches = axes.map(({ axis }, number) =>
      link.watch(
        { what: "samples", target: axis, fields: ["position_deg", ...boardAngle(axis)], rate_Hz: RATE_HZ },
        {
          samples: (values, rows, columns) => this.take(number, values, rows, columns),
          refused: (error) => (whyNotSeen.value = error.message),
          again: () => (isSeenWhole.value = false),
        },
      ),
    );
  }

  end(): void {
    for (const watch of this.watches) watch.close();
  }

  private take(number: number, values: Float64Array, rows: number, columns: number): void {
    for (let row = 0; row < rows; row++) this.waiting[number]!.push(values.slice(row * columns, (row + 1) * columns));
    this.join();
  }

  /** Make points of samples of one time. */
  private join(): void {
    const { axes } = this.made;
    let now = deviation.peek()?.now ?? 0;
    let isNew = false;
    while (this.waiting.every((rows) => rows.length > 0)) {
      const last_s = Math.max(...this.waiting.map((rows) => rows[0]![0]!));
      const late = this.waiting.find((rows) => rows[0]![0]! < last_s - SAME_s);
      if (late) {
        late.shift();
        continue;
      }
      this.waiting.forEach((rows, number) => {
        const { deg_per_unit, zero_deg } = axes[number]!;
        const [, shaft_deg, board_deg] = rows.shift()!;
        const shift_deg = (this.shifts_deg[number] ??= board_deg === undefined ? 0 : board_deg - shaft_deg!);
        this.place[number] = (shaft_deg! + shift_deg - zero_deg) / deg_per_unit;
      });
      this.into.add(this.place);
      now = this.off.take(this.place);
      isNew = true;
    }
    if (isNew) deviation.value = { largest: this.off.largest, now };
  }
}

let following: { name: string; made: Drawing; it: Following } | null = null;

/** Forget what was followed: another drawing begins. */
function clear(made: Drawing): void {
  followed.value = new Followed(made.axes.length);
  deviation.value = null;
  isSeenWhole.value = true;
  whyNotSeen.value = "";
}

effect(() => {
  const [made, now] = [drawing.value, run.value];
  const name = now && now.state === "running" && made ? now.run : null;
  if (following && (following.name !== name || following.made !== made)) {
    following.it.end();
    following = null;
  }
  if (!made || !now || name === null || following) return;
  const isFirst = partOf(now.run, made.machine) === 0;
  if (isFirst || !followed.peek() || followed.peek()!.axes !== made.axes.length) clear(made);
  const part = made.parts[partOf(now.run, made.machine) ?? 0];
  const isBeginning = isFirst && now.gone_ns < BEGINNING_NS;
  if (now.gone_ns >= BEGINNING_NS) isSeenWhole.value = false;
  const from: [number, number] = isBeginning || !part ? [0, 0] : pointsOf(made, lineAt(part, now.gone_ns / 1e9));
  following = { name, made, it: new Following(made, followed.peek()!, from) };
});

