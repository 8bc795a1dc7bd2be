/** All that is chosen of a plot, as a layout has it: what is as usual is left out. */

import { readTrigger, type TriggerSettings, USUAL_TRIGGER } from "../../model/trigger";
import { type PlotModel, readFixed, readRight, readXy, USUAL_WINDOW_s, WINDOWS_s, type XyChoice } from "./plot_model";
import { triggerOf } from "./plot_trigger";

/** `signals`: addresses of the fields that are drawn. */
export interface PlotSettings {
  signals: string[];
  window_s?: number;
  right?: Readonly<Record<string, string>>;
  xy?: XyChoice;
  fixed?: Readonly<Record<string, readonly [number, number]>>;
  trigger?: Partial<TriggerSettings>;
}

export function settingsOf(model: PlotModel): PlotSettings {
  const [window_s, right, xy] = [model.window_s.value, model.right.value, model.xy.value];
  const fixed = Object.fromEntries(model.fixed.value);
  const settings = Object.entries(triggerOf(model).settings.value);
  const trigger = Object.fromEntries(settings.filter(([name, value]) => value !== USUAL_TRIGGER[name as keyof TriggerSettings]));
  return {
    signals: model.signals,
    ...(window_s !== USUAL_WINDOW_s && { window_s }),
    ...(Object.keys(right).length && { right }),
    ...(xy && { xy }),
    ...(Object.keys(fixed).length && { fixed }),
    ...(Object.keys(trigger).length && { trigger }),
  };
}

/** Choose what a layout of unknown origin has; what it leaves out is as usual. */
export function choose(model: PlotModel, given: Readonly<Record<string, unknown>>, signals: readonly string[]): void {
  model.setSignals(signals);
  model.window_s.value = WINDOWS_s.find((each) => each === given["window_s"]) ?? USUAL_WINDOW_s;
  model.right.value = readRight(given["right"]) ?? {};
  model.xy.value = readXy(given["xy"] ?? null) ?? null;
  model.fixAll(readFixed(given["fixed"]));
  triggerOf(model).set(readTrigger(given["trigger"]) ?? USUAL_TRIGGER);
}
