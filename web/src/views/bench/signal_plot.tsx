/** Plots of signals of any devices, as a part of a page: `<SignalPlot id="bench 2" signals={["m1.yw", "m2.yw"]} />`. */

import { useEffect } from "preact/hooks";
import { devices } from "../../store";
import { besideOf } from "./axis_fields";
import { plotModelOf } from "./plot_model";
import { Plots } from "./plots";

interface SignalPlotProps {
  /** Name of what is kept of it: window, axes, cursors. */
  id: string;
  /** Addresses of the fields: device or axis, a dot, and the field. */
  signals: readonly string[];
  /** Hears which signals somebody has chosen. */
  onSignals?: ((signals: string[]) => void) | undefined;
}

export function SignalPlot({ id, signals, onSignals }: SignalPlotProps) {
  const axes = signals.map((address) => besideOf(address)?.axis ?? "");
  const known = axes.map((axis) => devices.value.get(axis)).find((device) => device !== undefined);
  const device = known ?? [...devices.value.values()].find(({ fields }) => fields.length > 0);
  const missing = [...new Set(axes.filter((axis) => !devices.value.has(axis)))];
  if (!device) return <p class="empty">No device of this bench has fields.</p>;
  return (
    <>
      {missing.length > 0 && <p class="soft">This bench has no {missing.join(", ")}.</p>}
      <Chosen id={id} device={device.name} signals={signals} onSignals={onSignals} />
    </>
  );
}

function Chosen({ id, device, signals, onSignals }: SignalPlotProps & { device: string }) {
  const model = plotModelOf(devices.value.get(device)!, id);
  const given = signals.join(" ");
  useEffect(() => {
    if (given !== model.signals.join(" ")) model.setSignals(signals);
  }, [model, given]);
  const chosen = model.signals.join(" ");
  useEffect(() => {
    if (chosen !== given) onSignals?.(model.signals);
  }, [chosen]);
  return <Plots model={model} isFilling />;
}
