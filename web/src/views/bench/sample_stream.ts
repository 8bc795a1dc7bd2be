/** Samples of an axis at one rate: a watch, and the ring that it fills. */

import { Ring } from "../../model/ring";
import type { Layer, Sampling } from "../../model/sampling";
import type { WatchHandle } from "../../net/channels";
import type { Refused } from "../../net/protocol";
import { link } from "../../store";

/** Speed of a bench up to which all samples can be had. */
const FULL_SPEED = 4;

/** What is asked of the bench, in its simulated time. */
export interface SampleRate {
  rate_Hz: number;
  /** Looks in each interval of which two samples have the extremes; 1: samples of moments. */
  points: number;
  kept_s: number;
}

/** Hears what has come. */
export interface StreamEars {
  came(values: Float64Array, rows: number, columns: number): void;
  refused(error: Refused): void;
}

export class SampleStream implements Layer {
  ring: Ring;
  sampling: Sampling;
  /** Samples that the bench lost for lack of room. */
  lost = 0;
  private watch: WatchHandle | null = null;
  private isGap = false;
  /** The start of the bench that the newest samples are of. */
  private instance: string | undefined;

  constructor(
    private readonly axis: string,
    private readonly rate: SampleRate,
    private readonly ears: StreamEars,
    width: number,
  ) {
    const isExtremes = rate.points > 1;
    this.ring = new Ring(Math.ceil(rate.kept_s * rate.rate_Hz) * (isExtremes ? 2 : 1), width);
    this.sampling = { interval_s: 1 / rate.rate_Hz, isExtremes };
  }

  get isOpen(): boolean {
    return this.watch !== null;
  }

  /** Watch these fields from now on. A bench that is much faster than real time gives so many samples in real time. */
  begin(fields: string[], speed: number): void {
    this.watch?.close();
    this.lost = 0; // each watch counts its own
    const rate_Hz = this.rate.rate_Hz / Math.max(speed / FULL_SPEED, 1);
    this.sampling = { ...this.sampling, interval_s: 1 / rate_Hz };
    this.watch = link.watch(
      { what: "samples", target: this.axis, fields, rate_Hz, points: this.rate.points },
      {
        samples: (values, rows, columns, lost) => this.take(values, rows, columns, lost),
        again: () => (this.isGap = true),
        refused: (error) => {
          this.end();
          this.ears.refused(error);
        },
      },
    );
  }

  end(): void {
    this.watch?.close();
    this.watch = null;
    this.isGap = true;
  }

  private take(values: Float64Array, rows: number, columns: number, lost: number): void {
    if (!rows) return;
    const instance = link.hello.peek()?.instance;
    if (instance !== this.instance) this.ring.restart();
    else if (this.isGap || lost > this.lost) this.ring.gap(); // no line across what was lost
    this.instance = instance;
    this.isGap = false;
    this.ring.push(values, rows, columns);
    this.lost = lost;
    this.ears.came(values, rows, columns);
  }
}
