/** The settings of a plot's trigger, and what it does. */

import { useEffect, useState } from "preact/hooks";
import type { TriggerSettings } from "../../model/trigger";
import { devices, hello } from "../../store";
import { fieldAt } from "./axis_fields";
import type { PlotModel } from "./plot_model";
import { linesOf, type PlotTrigger, triggerOf } from "./plot_trigger";

/** `isOpen`: the settings are shown, too. */
export function TriggerBar({ model, isOpen }: { model: PlotModel; isOpen: boolean }) {
  const trigger = triggerOf(model);
  const isOn = trigger.said.value !== "";
  const window_s = model.window_s.value;
  useEffect(() => {
    if (trigger.isOn) trigger.arm();
  }, [trigger, window_s]);
  if (!isOpen && !isOn) return null;
  return (
    <div class="row trigger-bar" role="group" aria-label="Trigger">
      {isOpen && <Settings model={model} trigger={trigger} />}
      <button type="button" class={isOn ? "" : "primary"} onClick={() => trigger.arm()}>
        {isOn ? "Arm again" : "Arm"}
      </button>
      {isOn && (
        <button type="button" onClick={() => trigger.stop()}>
          Trigger off
        </button>
      )}
      <span class="mono trigger-state" role="status" aria-live="polite">
        {trigger.said.value}
      </span>
    </div>
  );
}

function Settings({ model, trigger }: { model: PlotModel; trigger: PlotTrigger }) {
  const settings = trigger.settings.value;
  const choice = <Key extends keyof TriggerSettings>(key: Key, label: string, options: readonly (readonly [string, string])[], value = settings[key]) => (
    <select aria-label={label} value={String(value)} onChange={(event) => trigger.set({ [key]: event.currentTarget.value })}>
      {options.map(([each, text]) => (
        <option key={each} value={each}>
          {text}
        </option>
      ))}
    </select>
  );
  const kinds = hello.value?.fault_kinds.map(({ name }) => [name, name] as const) ?? [];
  const lines = linesOf();
  const unit = fieldAt(devices.value, trigger.signal)?.field.unit ?? "";
  return (
    <>
      {choice("on", "Trigger on", [
        ["field", "a field"],
        ["fault", "a fault"],
        ["step", "a step of a run"],
        ...(lines.length ? [["packet", "a packet"] as const] : []),
      ])}
      {settings.on === "field" && (
        <>
          {choice(
            "signal",
            "Field of the trigger",
            model.signals.map((name) => [name, name]),
            trigger.signal,
          )}
          {choice("edge", "Edge", [
            ["rising", "rises to"],
            ["falling", "falls to"],
            ["either", "passes"],
          ])}
          <NumberField label="Level" unit={unit} value={settings.level} onValue={(level) => trigger.set({ level })} />
          <NumberField label="Hysteresis" unit={unit} least={0} isTold value={settings.hysteresis} onValue={(hysteresis) => trigger.set({ hysteresis })} />
        </>
      )}
      {settings.on === "packet" && (
        <>
          {choice(
            "line",
            "Wire",
            lines.map((name) => [name, name]),
            trigger.line,
          )}
          <label>
            <span class="soft">with</span>
            <input
              class="mono"
              placeholder="any words"
              aria-label="Words of the packet, as in the filter of Wire"
              value={settings.words}
              onInput={(event) => trigger.set({ words: event.currentTarget.value })}
            />
          </label>
        </>
      )}
      {settings.on === "fault" && choice("kind", "Kind of fault", [["", "of any kind"], ...kinds])}
      {settings.on === "step" && (
        <>
          <label>
            <span class="soft">run</span>
            <input class="mono" placeholder="any" aria-label="Run" value={settings.run} onInput={(event) => trigger.set({ run: event.currentTarget.value })} />
          </label>
          <NumberField label="Step, 0: any" unit="" least={0} isTold value={settings.step} onValue={(step) => trigger.set({ step: Math.round(step) })} />
        </>
      )}
      <NumberField
        label="Before"
        unit="%"
        least={0}
        most={100}
        isTold
        value={settings.before_percent}
        onValue={(before_percent) => trigger.set({ before_percent })}
      />
      {choice("mode", "Mode", [
        ["once", "once"],
        ["normal", "normal"],
        ["auto", "auto"],
      ])}
    </>
  );
}

interface NumberFieldProps {
  label: string;
  unit: string;
  value: number;
  onValue: (value: number) => void;
  least?: number;
  most?: number;
  /** Whether the label is written before the field. */
  isTold?: boolean;
}

function NumberField({ label, unit, value, onValue, least = -Infinity, most = Infinity, isTold = false }: NumberFieldProps) {
  const [why, setWhy] = useState("");
  const take = (text: string) => {
    const typed = Number(text.replace("−", "-"));
    const isWrong = !text.trim() || !Number.isFinite(typed) || typed < least || typed > most;
    setWhy(isWrong ? `write a number${least > -Infinity ? ` from ${least}` : ""}${most < Infinity ? ` to ${most}` : ""}` : "");
    if (!isWrong) onValue(typed);
  };
  return (
    <label class="with-unit">
      {isTold && <span class="soft">{label.toLowerCase()}</span>}
      <input
        class="mono is-number"
        inputMode="decimal"
        aria-label={label}
        aria-invalid={why !== ""}
        defaultValue={String(value)}
        onInput={(event) => take(event.currentTarget.value)}
      />
      {unit && <span class="soft">{unit}</span>}
      {why && <span class="problem">{why}</span>}
    </label>
  );
}
