/** Path that the axes follow while a drawing runs, from samples of the bench; and its distance from the one asked
 * for. It goes on while other views are looked at. */

import { effect, signal } from "@preact/signals";
import type { Drawing } from "../../model/drawing";
import { partOf, pointsBetween } from "../../model/drawing";
import { PathDeviation } from "../../model/path_deviation";
import type { RunProgress } from "../../model/run_progress";
import { boardAngleOf, SampledPlaces } from "../../model/sampled_places";
import type { WatchHandle } from "../../net/channels";
import { devices, link } from "../../store";
import { drawing, run } from "./path_state";

const RATE_HZ = 200;
const MOST_POINTS = 200_000;
/** A run that is seen so early is seen whole: its axes have hardly moved. */
const BEGINNING_NS = 3e8;
/** The first samples come later than what is known of the run by so much at most. */
const LATER_s = 2;

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

class Following {
  private readonly watches: WatchHandle[];
  private readonly sampled: SampledPlaces;
  private off: PathDeviation | null = null;

  /** `pointsAt`: points of the path between which the machine is at a time of the bench. */
  constructor(
    private readonly made: Drawing,
    private readonly into: Followed,
    private readonly pointsAt: (at_s: number) => [number, number],
  ) {
    this.sampled = new SampledPlaces(made.axes);
    this.watches = made.axes.map(({ axis }, number) => {
      const board = boardAngleOf(devices.peek().get(axis)?.fields ?? []);
      const fields = board === undefined ? ["position_deg"] : ["position_deg", board];
      return link.watch(
        { what: "samples", target: axis, fields, rate_Hz: RATE_HZ },
        {
          samples: (values, rows, columns) => (this.sampled.take(number, values, rows, columns), this.join()),
          refused: (error) => (whyNotSeen.value = error.message),
          again: () => (isSeenWhole.value = false),
        },
      );
    });
  }

  end(): void {
    for (const watch of this.watches) watch.close();
  }

  /** Take the places that are complete. */
  private join(): void {
    let now: number | null = null;
    while (this.sampled.next()) {
      const { place, at_s } = this.sampled;
      this.into.add(place);
      this.off ??= this.begin(at_s);
      now = this.off.take(place);
    }
    if (now !== null) deviation.value = { largest: this.off!.largest, now };
  }

  private begin(at_s: number): PathDeviation {
    const off = new PathDeviation(this.made.places, this.made.axes.length, ...this.pointsAt(at_s));
    off.largest = deviation.peek()?.largest ?? 0;
    return off;
  }
}

let following: { name: string; made: Drawing; it: Following } | null = null;
/** Digest of the drawing whose axes were followed. */
let followedOf = "";

/** Forget what was followed: another drawing is shown, or this one begins. */
function clear(made: Drawing): void {
  followedOf = made.digest;
  followed.value = new Followed(made.axes.length);
  deviation.value = null;
  isSeenWhole.value = true;
  whyNotSeen.value = "";
}

/** Time of a run's plan that is gone at most at a time of the bench. */
function mostGone_s(run: RunProgress, at_s: number): number {
  const gone_s = run.gone_ns / 1e9;
  const since_s = run.started_at_ns === null ? gone_s : at_s - run.started_at_ns / 1e9;
  return Math.max(Math.min(since_s, gone_s + LATER_s * run.pace), gone_s);
}

effect(() => {
  const [made, now] = [drawing.value, run.value];
  const name = now && now.state === "running" && made ? now.run : null;
  if (following && (following.name !== name || following.made !== made)) {
    following.it.end();
    following = null;
  }
  if (made && made.digest !== followedOf) clear(made);
  if (!made || !now || name === null || following) return;
  const number = partOf(now, made);
  if (number === 0 || !followed.peek()) clear(made);
  const part = made.parts[number ?? 0];
  if (now.gone_ns >= BEGINNING_NS) isSeenWhole.value = false;
  const gone_s = now.gone_ns / 1e9;
  const pointsAt = (at_s: number) => pointsBetween(made, part, gone_s, mostGone_s(now, at_s));
  following = { name, made, it: new Following(made, followed.peek()!, pointsAt) };
});
