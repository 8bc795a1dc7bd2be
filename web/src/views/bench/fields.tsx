/** All fields of an axis with their values, now. */

import { signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { shown } from "../../model/numbers";
import type { DeviceRow, FieldRow } from "../../model/door";
import { link, may } from "../../store";
import { notify, notifyError } from "../../parts/notices";
import { check } from "../../model/parameters";

const EVERY_MS = 500;
const filter = signal("");

export function useFieldValues(device: DeviceRow, every_ms = EVERY_MS): Record<string, number | null> {
  const [values, setValues] = useState<Record<string, number | null>>({});
  useEffect(() => {
    let isThere = true;
    const read = async () => {
      if (document.hidden || link.state.peek() !== "open") return;
      const state = await link.ask("state", device.name).catch(() => null);
      if (state && isThere) setValues(state);
    };
    void read();
    const timer = window.setInterval(() => void read(), every_ms);
    return () => {
      isThere = false;
      window.clearInterval(timer);
    };
  }, [device.name, every_ms]);
  return values;
}

export function Fields({ device }: { device: DeviceRow }) {
  const values = useFieldValues(device);
  const rows = device.fields.filter((field) => `${field.name} ${field.meaning}`.toLowerCase().includes(filter.value.toLowerCase()));
  return (
    <>
      <input
        type="search"
        placeholder="filter"
        aria-label="Filter the fields"
        value={filter.value}
        onInput={(event) => (filter.value = event.currentTarget.value)}
      />
      <div class="scroll-x scroll-y" tabIndex={0} role="region" aria-label={`Fields of ${device.name}`}>
        <table>
          <thead>
            <tr>
              <th scope="col">field</th>
              <th scope="col" class="num">
                value
              </th>
              <th scope="col">unit</th>
            </tr>
          </thead>
          <tbody>
            {rows.map((field) => (
              <tr key={field.name}>
                <th scope="row" class="field-name">
                  <span class="mono">{field.name}</span> <span class="soft">{field.meaning}</span>
                </th>
                <td class="num">
                  {field.is_settable && may("operator") ? (
                    <SetField device={device.name} field={field.name} value={values[field.name]} />
                  ) : (
                    valueText(field, values[field.name])
                  )}
                </td>
                <td>{field.unit}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </>
  );
}

function valueText(field: FieldRow, value: number | null | undefined): string {
  return field.type.startsWith("i") && typeof value === "number" ? String(value) : shown(value, 4);
}

/** A value that can be set: Enter sends it, Escape leaves it. */
function SetField({ device, field, value }: { device: string; field: string; value: number | null | undefined }) {
  const [typed, setTyped] = useState<string | null>(null);
  const send = async () => {
    const checked = check({ name: field }, typed ?? "");
    if (!("value" in checked)) {
      notify(`${field}: ${"problem" in checked ? checked.problem : "write a number"}`, true);
      return;
    }
    try {
      await link.ask("set", device, { field, value: checked.value });
      setTyped(null);
    } catch (error) {
      notifyError(error);
    }
  };
  return (
    <input
      class="mono is-number"
      aria-label={`Set ${field}`}
      inputMode="decimal"
      value={typed ?? (value === null || value === undefined ? "" : String(Number(value.toPrecision(7))))}
      onFocus={(event) => event.currentTarget.select()}
      onInput={(event) => setTyped(event.currentTarget.value)}
      onBlur={() => setTyped(null)}
      onKeyDown={(event) => {
        if (event.key === "Enter") void send();
        if (event.key === "Escape") setTyped(null);
      }}
    />
  );
}
