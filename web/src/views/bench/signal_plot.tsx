/** Plots of signals of any devices, as a part of a page: `<SignalPlot id="bench 2" given={{signals: ["m1.yw", "m2.yw"]}} />`. */

import { useEffect, useRef } from "preact/hooks";
import { devices } from "../../store";
import { besideOf } from "./axis_fields";
import { plotModelOf } from "./plot_model";
import { choose, type PlotSettings, settingsOf } from "./plot_settings";
import { Plots } from "./plots";

interface SignalPlotProps {
  /** Name of what is kept of it: cursors. */
  id: string;
  /** Addresses of the fields: device or axis, a dot, and the field. */
  signals: readonly string[];
  /** These, and what else of `PlotSettings` is chosen, of unknown origin. */
  given: Readonly<Record<string, unknown>>;
  /** Hears what somebody has chosen. */
  onChosen: (settings: PlotSettings) => void;
}

export function SignalPlot({ signals, ...others }: SignalPlotProps) {
  const axes = signals.map((address) => besideOf(address)?.axis ?? "");
  const known = axes.map((axis) => devices.value.get(axis)).find((device) => device !== undefined);
  const device = known ?? [...devices.value.values()].find(({ fields }) => fields.length > 0);
  const missing = [...new Set(axes.filter((axis) => !devices.value.has(axis)))];
  if (!device) return <p class="empty">No device of this bench has fields.</p>;
  return (
    <>
      {missing.length > 0 && <p class="soft">This bench has no {missing.join(", ")}.</p>}
      <Chosen device={device.name} signals={signals} {...others} />
    </>
  );
}

function Chosen({ id, device, signals, given, onChosen }: SignalPlotProps & { device: string }) {
  const model = plotModelOf(devices.value.get(device)!, id);
  const [wanted, chosen] = [JSON.stringify(given), JSON.stringify(settingsOf(model))];
  const told = useRef("");
  useEffect(() => {
    if (wanted !== told.current && wanted !== JSON.stringify(settingsOf(model))) choose(model, given, signals);
  }, [model, wanted]);
  useEffect(() => {
    const now = settingsOf(model);
    told.current = JSON.stringify(now);
    if (told.current !== wanted) onChosen(now);
  }, [chosen]);
  return <Plots model={model} isFilling />;
}
