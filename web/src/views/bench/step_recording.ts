/** Carry out a step of the set-point and record the response. */

import { type StepFigures, stepFigures } from "../../model/step_response";
import type { DeviceRow } from "../../model/door";
import { Refused } from "../../net/protocol";
import { link } from "../../store";
import { setpointOf } from "./axis_fields";
import { askVerb } from "./verbs";

export interface StepResponse {
  /** Seconds from the step on. */
  times_s: number[];
  position_deg: number[];
  setpoint_deg: number[];
  figures: StepFigures;
}

const RATE_HZ = 1000;
const STILL_ms = 300;
const BEFORE_s = 0.02;
const LATE_ms = 4000;

/** Make a step by so many degrees from where the shaft is held, and record so many seconds. Throws Refused. */
export async function recordStep(device: DeviceRow, step_deg: number, length_s: number): Promise<StepResponse> {
  const setpoint = setpointOf(device);
  if (!setpoint) throw new Refused("cannot", `${device.name} has no set-point that could step`);
  if (device.verbs["mode"]) await askVerb(device.name, "mode", { mode: "position" });
  if (device.verbs["enable"]) await askVerb(device.name, "enable", {});
  await new Promise((resolve) => setTimeout(resolve, STILL_ms));
  const before = await link.ask("state", device.name);
  const from = before[setpoint] ?? NaN;
  const rows: [number, number, number][] = [];
  const position = device.fields.some((field) => field.name === "yw") ? "yw" : "position_deg";
  const done = new Promise<number>((resolve, reject) => {
    let stepped_s = NaN;
    const timer = setTimeout(
      () => reject(new Refused("failed", "the set-point did not step: is the board at its main menu, and is it calibrated?")),
      LATE_ms + length_s * 1000,
    );
    const watch = link.watch(
      { what: "samples", target: device.name, fields: [setpoint, position], rate_Hz: RATE_HZ },
      {
        samples: (values, count, columns) => {
          for (let row = 0; row < count; row++) {
            const [at_s = NaN, wanted = NaN, is = NaN] = values.subarray(row * columns, row * columns + 3);
            rows.push([at_s, wanted, is]);
            if (Number.isNaN(stepped_s) && Math.abs(wanted - from) > Math.abs(step_deg) / 2) stepped_s = at_s;
            if (at_s - stepped_s < length_s || Number.isNaN(stepped_s)) continue;
            clearTimeout(timer);
            watch.close();
            return resolve(stepped_s);
          }
        },
        refused: (error) => (clearTimeout(timer), reject(error)),
      },
    );
    askVerb(device.name, "position", { position_deg: from + step_deg }).catch((error: unknown) => {
      clearTimeout(timer);
      watch.close();
      reject(error instanceof Error ? error : new Error(String(error)));
    });
  });
  const stepped_s = await done;
  const shown = rows.filter(([at_s]) => at_s >= stepped_s - BEFORE_s && at_s <= stepped_s + length_s);
  const times_s = shown.map(([at_s]) => at_s - stepped_s);
  const position_deg = shown.map(([, , is]) => is - from);
  const setpoint_deg = shown.map(([, wanted]) => wanted - from);
  return { times_s, position_deg, setpoint_deg, figures: stepFigures(times_s, position_deg, 0, step_deg) };
}
