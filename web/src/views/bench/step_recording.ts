/** Carry out a step of the set-point, record the response, and go back. */

import { otherMotion, type StepFigures, stepFigures, type StepRows } from "../../model/step_response";
import type { DeviceRow } from "../../model/door";
import { Refused } from "../../net/protocol";
import { notifyError } from "../../parts/notices";
import { link } from "../../store";
import { setpointOf } from "./axis_fields";
import { askVerb } from "./verbs";

export interface StepResponse {
  /** Times from the step on; positions in deg from where the shaft was held. */
  rows: StepRows;
  figures: StepFigures;
  /** Gains at that time. */
  gains: Readonly<Record<string, number>>;
  rate_Hz: number;
}

/** As `hil step` looks; less where pages may have less. */
const RATES_HZ = [4000, 1000];
/** The letter x of a Mechaduino: its loop holds a position. */
const POSITION = 120;
const LOOK_ms = 100;
/** The shaft is still where it moved by less between two looks; it is given so many. */
const STILL_deg = 0.02;
const MOST_LOOKS = 50;
const BEFORE_s = 0.02;
const LATE_ms = 4000;

/** Make a step by so many degrees from where the shaft is held, record so many seconds, and go back, also where it was
 * stopped by `signal` or something went wrong. Throws Refused. */
export async function recordStep(device: DeviceRow, step_deg: number, length_s: number, signal: AbortSignal): Promise<StepResponse> {
  const setpoint = setpointOf(device);
  if (!setpoint) throw new Refused("cannot", `${device.name} has no set-point that could step`);
  const position = device.fields.some((field) => field.name === "yw") ? "yw" : "position_deg";
  if (!isHeld(await link.ask("state", device.name))) {
    if (device.verbs["mode"]) await askVerb(device.name, "mode", { mode: "position" });
    if (device.verbs["enable"]) await askVerb(device.name, "enable", {});
  }
  await untilStill(device, position, signal);
  const before = await link.ask("state", device.name);
  const from = before[setpoint] ?? NaN;
  const stepped = new Stepped(device, setpoint, position, from);
  try {
    const { all, rate_Hz } = await stepped.record(step_deg, length_s, signal);
    const at = all.setpoint.findIndex((value) => Math.abs(value - from) > Math.abs(step_deg) / 2);
    const stepped_s = all.times_s[at] ?? NaN;
    const shown = all.times_s.map((at_s) => at_s >= stepped_s - BEFORE_s && at_s <= stepped_s + length_s);
    const part = (values: readonly number[], less: number) => values.filter((_, row) => shown[row]).map((value) => value - less);
    const rows = { times_s: part(all.times_s, stepped_s), setpoint: part(all.setpoint, from), position: part(all.position, from) };
    if (otherMotion(rows, step_deg, step_deg)) throw new Refused("not_now", `${device.name}: ${otherMotion(rows, step_deg, step_deg)}`);
    const gains = Object.fromEntries((device.verbs["gains"]?.parameters ?? []).map(({ name }) => [name, before[name] ?? NaN]));
    return { rows, figures: stepFigures(rows), gains, rate_Hz };
  } finally {
    await stepped.goBack().catch(notifyError);
  }
}

/** Whether a loop holds the shaft already: to switch it on would let the set-point be where the shaft is, a little further
 * with each step. */
function isHeld(state: Record<string, number | null>): boolean {
  return (state["loop_on"] ?? state["is_enabled"]) === 1 && (state["mode"] ?? POSITION) === POSITION;
}

/** Wait until a shaft stands, as far as it does. */
async function untilStill(device: DeviceRow, position: string, signal: AbortSignal): Promise<void> {
  let last = NaN;
  for (let look = 0; look < MOST_LOOKS; look++) {
    await new Promise((resolve) => setTimeout(resolve, LOOK_ms));
    if (signal.aborted) throw stopped(device);
    const now = (await link.ask("state", device.name))[position] ?? NaN;
    if (look > 1 && Math.abs(now - last) < STILL_deg) return;
    last = now;
  }
}

function stopped(device: DeviceRow): Refused {
  return new Refused("not_now", `${device.name}: the step was stopped`);
}

interface Recorded {
  all: { times_s: number[]; setpoint: number[]; position: number[] };
  rate_Hz: number;
}

/** A step that is under way. */
class Stepped {
  private readonly all: Recorded["all"] = { times_s: [], setpoint: [], position: [] };
  private hasAsked = false;

  constructor(
    private readonly device: DeviceRow,
    private readonly setpoint: string,
    private readonly position: string,
    private readonly from: number,
  ) {}

  async record(step_deg: number, length_s: number, signal: AbortSignal): Promise<Recorded> {
    for (const rate_Hz of RATES_HZ) {
      try {
        await this.recordAt(rate_Hz, step_deg, length_s, signal);
        return { all: this.all, rate_Hz };
      } catch (error) {
        const isTooFast = error instanceof Refused && error.code === "bad_parameter" && /rate_Hz/.test(error.message);
        if (!isTooFast || this.hasAsked || rate_Hz === RATES_HZ.at(-1)) throw error;
      }
    }
    throw new Refused("failed", "no rate is left");
  }

  private recordAt(rate_Hz: number, step_deg: number, length_s: number, signal: AbortSignal): Promise<void> {
    const { device, from, all } = this;
    return new Promise((resolve, reject) => {
      let stepped_s = NaN;
      const end = (error?: unknown) => {
        clearTimeout(timer);
        signal.removeEventListener("abort", stop);
        watch.close();
        if (error === undefined) resolve();
        else reject(error instanceof Error ? error : new Error(String(error)));
      };
      const stop = () => end(stopped(device));
      const why = `${device.name}: the set-point did not step within ${LATE_ms / 1000} s`;
      const timer = setTimeout(() => end(new Refused("failed", why)), LATE_ms + length_s * 1000);
      const watch = link.watch(
        { what: "samples", target: device.name, fields: [this.setpoint, this.position], rate_Hz },
        {
          samples: (values, count, columns) => {
            if (!this.hasAsked) this.step(from + step_deg).catch(end);
            for (let row = 0; row < count; row++) {
              const [at_s = NaN, wanted = NaN, is = NaN] = values.subarray(row * columns, row * columns + 3);
              all.times_s.push(at_s);
              all.setpoint.push(wanted);
              all.position.push(is);
              if (Number.isNaN(stepped_s) && Math.abs(wanted - from) > Math.abs(step_deg) / 2) stepped_s = at_s;
              if (at_s - stepped_s >= length_s) return end();
            }
          },
          refused: end,
          again: () => end(new Refused("gone", "the connection was lost meanwhile")),
        },
      );
      signal.addEventListener("abort", stop);
    });
  }

  private async step(to: number): Promise<void> {
    this.hasAsked = true;
    await askVerb(this.device.name, "position", { position_deg: to });
  }

  /** Go back to where the shaft was held, unless something else has moved the set-point since: it knows why. */
  async goBack(): Promise<void> {
    const { device, setpoint, from } = this;
    if (!this.hasAsked) return;
    const last = this.all.setpoint.at(-1);
    const now = (await link.ask("state", device.name))[setpoint];
    if (now === from || (now !== last && this.all.setpoint.some((value) => value !== from))) return;
    await askVerb(device.name, "position", { position_deg: from });
  }
}
