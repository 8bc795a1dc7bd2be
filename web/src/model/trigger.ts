/** A trigger as an oscilloscope has it: when it fires, and which time is shown then. Pure. */

export type TriggerOn = "field" | "fault" | "step" | "packet";
export type Edge = "rising" | "falling" | "either";
export type TriggerMode = "once" | "normal" | "auto";

export interface TriggerSettings {
  on: TriggerOn;
  /** Address of a field; empty: the first that is drawn. */
  signal: string;
  edge: Edge;
  level: number;
  /** By so much the signal has to go back before the next edge counts. */
  hysteresis: number;
  /** Kind of fault; empty: any. */
  kind: string;
  /** Run and number of its step; empty, 0: any. */
  run: string;
  step: number;
  /** Segment or bus, and words that its packet has. */
  line: string;
  words: string;
  mode: TriggerMode;
  /** Part of the window that is before the trigger, in percent. */
  before_percent: number;
}

export const USUAL_TRIGGER: TriggerSettings = {
  on: "field",
  signal: "",
  edge: "rising",
  level: 0,
  hysteresis: 0,
  kind: "",
  run: "",
  step: 0,
  line: "",
  words: "",
  mode: "once",
  before_percent: 20,
};

const CHOICES: Partial<Record<keyof TriggerSettings, readonly unknown[]>> = {
  on: ["field", "fault", "step", "packet"],
  edge: ["rising", "falling", "either"],
  mode: ["once", "normal", "auto"],
};

/** Read settings that were kept; what is none of its kind is as usual. */
export function readTrigger(raw: unknown): TriggerSettings | undefined {
  if (typeof raw !== "object" || raw === null) return undefined;
  const told = raw as Record<string, unknown>;
  const read = { ...USUAL_TRIGGER } as Record<keyof TriggerSettings, unknown>;
  for (const key of Object.keys(USUAL_TRIGGER) as (keyof TriggerSettings)[]) {
    const value = told[key];
    const isFit = typeof value === typeof USUAL_TRIGGER[key] && (CHOICES[key]?.includes(value) ?? true);
    if (isFit && (typeof value !== "number" || Number.isFinite(value))) read[key] = value;
  }
  const { hysteresis, before_percent, step } = read as unknown as TriggerSettings;
  const numbers = { hysteresis: Math.max(hysteresis, 0), before_percent: Math.min(Math.max(before_percent, 0), 100), step: Math.max(Math.round(step), 0) };
  return { ...(read as unknown as TriggerSettings), ...numbers };
}

/** Finds edges in values as they come. Before an edge counts the signal has to be on the other side of the level, by the
 * hysteresis at least. Extremes of an interval come one after the other, so an edge between two samples is not missed. */
export class EdgeFinder {
  private isLow = false;
  private isHigh = false;

  constructor(
    private readonly edge: Edge,
    private readonly level: number,
    private readonly hysteresis: number,
  ) {}

  /** Take the next value; true: it ends an edge. One that is missing is passed over. */
  take(value: number): boolean {
    if (value !== value) return false;
    const { edge, level, hysteresis } = this;
    const rises = this.isLow && value >= level && edge !== "falling";
    const falls = this.isHigh && value <= level && edge !== "rising";
    if (value >= level) this.isLow = false;
    if (value <= level) this.isHigh = false;
    if (value < level && value <= level - hysteresis) this.isLow = true;
    if (value > level && value >= level + hysteresis) this.isHigh = true;
    return rises || falls;
  }
}

export type AcquisitionState = "off" | "armed" | "waiting" | "triggered" | "held";

/** Least time for which an automatic trigger waits before the plots move on without one. */
const AUTO_s = 1;

/** One picture after the other: from arming to the end of what is behind the trigger. */
export class Acquisition {
  state: AcquisitionState = "armed";
  /** Time of the last trigger. */
  at_s = NaN;
  private readonly before_s: number;
  private since_s: number;

  constructor(
    readonly mode: TriggerMode,
    readonly window_s: number,
    before_percent: number,
    begin_s: number,
  ) {
    this.before_s = (window_s * before_percent) / 100;
    this.since_s = begin_s;
  }

  /** What the trigger is about fires: it counts where it is waited for, and behind the last picture. */
  fire(at_s: number): void {
    if (this.state === "armed" && at_s - this.since_s >= this.before_s) this.state = "waiting";
    if (this.state !== "waiting" || at_s < this.since_s) return;
    this.at_s = at_s;
    this.state = "triggered";
  }

  /** Go on to a time; answers the window of a picture that is complete. */
  advance(now_s: number): [number, number] | null {
    if (now_s < this.since_s) this.beginAgain(now_s);
    if (this.state === "armed" && now_s - this.since_s >= this.before_s) this.state = "waiting";
    if (this.state !== "triggered") return null;
    const from_s = this.at_s - this.before_s;
    const to_s = from_s + this.window_s;
    if (now_s < to_s) return null;
    this.since_s = to_s;
    this.state = this.mode === "once" ? "held" : "waiting";
    return [from_s, to_s];
  }

  /** The clock of the bench began anew: what was before is of another run. */
  private beginAgain(now_s: number): void {
    this.since_s = now_s;
    if (this.state === "triggered") this.state = "armed";
  }

  /** Whether an automatic trigger has waited long enough: the plots move on. */
  isFree(now_s: number): boolean {
    return this.mode === "auto" && this.state === "waiting" && now_s - this.since_s > Math.max(this.window_s, AUTO_s);
  }
}

/** Say the state: "waiting", "triggered at 12.3456 s, ±0.5 ms". `resolution_s`: how well the time is known; 0: exactly. */
export function stateText({ state, at_s }: Pick<Acquisition, "state" | "at_s">, resolution_s: number): string {
  const at = Number.isNaN(at_s) ? "" : `triggered at ${at_s.toFixed(4)} s${resolution_s > 0 ? `, ±${Number((resolution_s * 1000).toPrecision(2))} ms` : ""}`;
  if (state === "held") return at;
  if (state === "triggered") return `${at}, collecting`;
  return state === "waiting" && at ? `${at}; waiting` : state;
}
