/** One field as a large number, with its unit, and a range that it should keep. */

import { useEffect, useRef } from "preact/hooks";
import { givenNumber, type PanelRow } from "../../model/layout";
import { digitsOf, shown } from "../../model/numbers";
import { devices } from "../../store";
import { besideOf, drawable, fieldAt } from "../../views/bench/axis_fields";
import { changePanel, give } from "../desk";
import type { BodyProps } from "../kinds";
import { Choice } from "../panel";
import { useFields, valueAt } from "../values";
import { write } from "../../parts/write";

const VALUES_EVERY_MS = 100;

export function NumberBody({ row }: BodyProps) {
  const place = useRef<HTMLDivElement>(null);
  const value = useRef<HTMLElement>(null);
  const alarm = useRef<HTMLElement>(null);
  const found = fieldAt(devices.value, row.of);
  const [low, high] = [givenNumber(row, "low"), givenNumber(row, "high")];
  const unit = found?.field.unit ?? "";
  useFields([row.of]);
  useEffect(() => {
    const tell = () => {
      const now = valueAt(row.of);
      write(value.current, shown(now, digitsOf(unit)));
      const why = low !== null && now < low ? `below ${shown(low, digitsOf(unit))}` : high !== null && now > high ? `above ${shown(high, digitsOf(unit))}` : "";
      write(alarm.current, why);
      place.current?.classList.toggle("is-bad", why !== "");
    };
    tell();
    const timer = window.setInterval(tell, VALUES_EVERY_MS);
    return () => window.clearInterval(timer);
  }, [row.of, low, high, unit]);
  return (
    <div ref={place} class="big-number">
      <span class="soft">{row.of}</span>
      <span class="big-value">
        <span class="mono" ref={value} /> <span class="unit">{unit}</span>
      </span>
      <strong class="problem" role="status" ref={alarm} />
      <span class="soft meaning">{found?.field.meaning}</span>
    </div>
  );
}

export function NumberSettings({ row }: { row: PanelRow }) {
  const of = besideOf(row.of);
  const names = [...devices.value.values()].filter(({ fields }) => fields.length > 0).map(({ name }) => name);
  const device = devices.value.get(of?.axis ?? "");
  const fields = device ? drawable(device).map(({ name }) => name) : [];
  const choose = (axis: string) => {
    const there = drawable(devices.peek().get(axis)!).map(({ name }) => name);
    const field = there.find((name) => name === of?.field) ?? there.find((name) => name === "position_deg") ?? there[0] ?? "";
    changePanel(row.id, { of: `${axis}.${field}` });
  };
  return (
    <>
      <Choice label="Device" value={of?.axis ?? ""} options={names} onChange={choose} />
      <Choice label="Field" value={of?.field ?? ""} options={fields} onChange={(field) => changePanel(row.id, { of: `${of?.axis}.${field}` })} />
      <Bound row={row} name="low" label="Alarm below" />
      <Bound row={row} name="high" label="Alarm above" />
    </>
  );
}

/** One end of the range; empty: there is none. */
function Bound({ row, name, label }: { row: PanelRow; name: string; label: string }) {
  const value = givenNumber(row, name);
  return (
    <label class="row">
      {label}
      <input
        class="mono is-bound"
        inputMode="decimal"
        value={value === null ? "" : String(value)}
        onInput={(event) => {
          const text = event.currentTarget.value.trim();
          const number = text === "" ? null : Number(text);
          const isNumber = number === null || Number.isFinite(number);
          event.currentTarget.setAttribute("aria-invalid", String(!isNumber));
          if (isNumber) give(row, { [name]: number });
        }}
      />
    </label>
  );
}
