/** The trigger of plots: it waits for a value, a fault, a packet or a step of a run, holds the picture about it, and fills that from the
 * recording. It goes on while other views are looked at. */

import { effect, signal } from "@preact/signals";
import { Kept } from "../../kept";
import { Acquisition, EdgeFinder, readTrigger, stateText, type TriggerSettings, USUAL_TRIGGER } from "../../model/trigger";
import { notifyError } from "../../parts/notices";
import { pastAt } from "../../past";
import { activeFaults, benchTime_s, hello, runs } from "../../store";
import { feedOf } from "./axis_feed";
import { besideOf } from "./axis_fields";
import { packetEars } from "./packet_ears";
import { allOf } from "./past_samples";
import type { PlotModel } from "./plot_model";
import { wantedOf } from "./plot_save";

const LOOK_MS = 50;
/** A recording's first sample may come a little later than it is asked for. */
const EARLIER_s = 0.002;

/** Wires of the bench on which packets pass. */
export function linesOf(): string[] {
  return [...(hello.value?.segments ?? []), ...(hello.value?.buses ?? [])];
}

export class PlotTrigger {
  readonly settings: Kept<TriggerSettings>;
  /** What it does, in words; empty: it is off. */
  readonly said = signal("");
  private ends: (() => void)[] = [];
  private acquisition: Acquisition | null = null;
  /** How well the time is known at which it fires. */
  private resolution_s = 0;
  /** Counts what was captured: the recording may answer when the next picture is there. */
  private captured = 0;

  constructor(private readonly model: PlotModel) {
    this.settings = new Kept(`plot.${model.id}.trigger`, () => USUAL_TRIGGER, readTrigger);
  }

  set(change: Partial<TriggerSettings>): void {
    this.settings.value = { ...this.settings.peek(), ...change };
    if (this.isOn) this.arm();
  }

  get isOn(): boolean {
    return this.acquisition !== null;
  }

  /** Address of the field that it looks at. */
  get signal(): string {
    const { signal } = this.settings.value;
    const { signals } = this.model;
    return signals.includes(signal) ? signal : (signals[0] ?? "");
  }

  /** Wire whose packets it looks at. */
  get line(): string {
    const lines = linesOf();
    const { line } = this.settings.value;
    return lines.includes(line) ? line : (lines[0] ?? "");
  }

  /** Wait for the next trigger. */
  arm(): void {
    this.stop();
    const { mode, before_percent } = this.settings.peek();
    this.model.live();
    this.acquisition = new Acquisition(mode, this.model.window_s.peek(), before_percent, this.now_s());
    for (const [axis, fields] of wantedOf(this.model)) this.ends.push(feedOf(axis).want(fields, true));
    this.ends.push(this.listen());
    const timer = window.setInterval(() => this.look(), LOOK_MS);
    this.ends.push(() => window.clearInterval(timer));
    this.look();
  }

  stop(): void {
    for (const end of this.ends) end();
    this.ends = [];
    this.acquisition = null;
    this.said.value = "";
  }

  private now_s(): number {
    const { last_s } = this.model.feed.layers[0]!.ring;
    return Number.isNaN(last_s) ? benchTime_s() : last_s;
  }

  private fire(at_s: number): void {
    this.acquisition?.fire(at_s);
  }

  /** Hear what it is about; answers the function that ends it. */
  private listen(): () => void {
    const settings = this.settings.peek();
    this.resolution_s = 0;
    switch (settings.on) {
      case "fault":
        return this.hearFaults(settings.kind);
      case "packet":
        return packetEars.hear(this.line, settings.words, (at_s) => this.fire(at_s));
      case "step":
        return this.hearSteps(settings.run.trim(), settings.step);
      default:
        return this.hearField(settings);
    }
  }

  private hearField({ edge, level, hysteresis }: TriggerSettings): () => void {
    const address = besideOf(this.signal);
    if (!address) return () => undefined;
    const feed = feedOf(address.axis);
    const finder = new EdgeFinder(edge, level, hysteresis);
    return feed.hear((values, rows, columns) => {
      const column = feed.column(address.field);
      if (column >= columns) return;
      const { interval_s, isExtremes } = feed.finest.sampling;
      this.resolution_s = isExtremes ? interval_s / 2 : interval_s;
      for (let row = 0; row < rows; row++) {
        if (finder.take(values[row * columns + column]!)) this.fire(values[row * columns]!);
      }
    });
  }

  private hearFaults(kind: string): () => void {
    const known = new Set(activeFaults.peek().map(({ number }) => number));
    return effect(() => {
      for (const fault of activeFaults.value) {
        if (known.has(fault.number)) continue;
        known.add(fault.number);
        if (!kind || fault.kind === kind) this.fire(fault.begin_s ?? benchTime_s());
      }
    });
  }

  private hearSteps(run: string, step: number): () => void {
    const known = new Map(runs.peek().map((each) => [each.run, each.step]));
    return effect(() => {
      for (const each of runs.value) {
        const isNew = each.state === "running" && known.get(each.run) !== each.step;
        known.set(each.run, each.step);
        if (!isNew || (run && each.run !== run) || (step && each.step !== step)) continue;
        this.fire(each.step_at_ns === null ? benchTime_s() : each.step_at_ns / 1e9);
      }
    });
  }

  private look(): void {
    const { acquisition } = this;
    if (!acquisition) return;
    this.said.value = stateText(acquisition, this.resolution_s);
    if (pastAt.peek() !== null) return; // what is held is of now
    const now_s = this.now_s();
    const window = acquisition.advance(now_s);
    if (window) void this.capture(...window, acquisition.at_s);
    else if (acquisition.isFree(now_s) && this.model.triggered_s.peek() !== null) this.model.live();
  }

  /** Hold the picture of what the page has, and of what the recording has as soon as that is there. */
  private async capture(from_s: number, to_s: number, at_s: number): Promise<void> {
    const number = ++this.captured;
    const { model } = this;
    const show = (found: Parameters<PlotModel["hold"]>[2]) => {
      model.hold(from_s, to_s, found);
      model.triggered_s.value = at_s;
    };
    show(new Map());
    try {
      const found = await allOf(wantedOf(model), from_s - EARLIER_s, to_s);
      const isHeld = number === this.captured && model.triggered_s.peek() === at_s && model.from_s.peek() === from_s && model.to_s.peek() === to_s;
      if (isHeld && found.size) show(found);
    } catch (error) {
      notifyError(error);
    }
  }
}

const triggers = new WeakMap<PlotModel, PlotTrigger>();

export function triggerOf(model: PlotModel): PlotTrigger {
  let trigger = triggers.get(model);
  if (!trigger) triggers.set(model, (trigger = new PlotTrigger(model)));
  return trigger;
}
