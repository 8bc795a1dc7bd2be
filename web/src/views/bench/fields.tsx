/** All fields of an axis with their values, now. */

import { useEffect, useId, useState } from "preact/hooks";
import { KeptForms, keptText, ownOf } from "../../kept";
import { shown } from "../../model/numbers";
import type { DeviceRow, FieldRow } from "../../model/door";
import { askPast, LANE, pastAt } from "../../past";
import { link, may } from "../../store";
import { notifyError } from "../../parts/notices";
import { check } from "../../model/parameters";

const EVERY_MS = 500;
const filter = keptText("bench.fields.filter");
/** Values that were typed and not sent, by axis and field. */
const unsent = new KeptForms("bench.fields");

/** All fields of an axis, now or at a time of the past. */
async function stateOf(axis: string, at_s: number | null): Promise<Record<string, number | null> | null> {
  if (at_s === null) return link.ask("state", axis);
  const told = await askPast("past_state", { at_s, lane: LANE });
  return told?.axes[axis] ?? null;
}

export function useFieldValues(device: DeviceRow, every_ms = EVERY_MS): Record<string, number | null> {
  const [values, setValues] = useState<Record<string, number | null>>({});
  const at_s = pastAt.value;
  useEffect(() => {
    let isThere = true;
    const read = async () => {
      if (document.hidden || link.state.peek() !== "open") return;
      const state = await stateOf(device.name, at_s).catch(() => null);
      if (state && isThere) setValues(state);
    };
    void read();
    if (at_s !== null) return () => void (isThere = false);
    const timer = window.setInterval(() => void read(), every_ms);
    return () => {
      isThere = false;
      window.clearInterval(timer);
    };
  }, [device.name, every_ms, at_s]);
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

/** A value that can be set: Enter sends it, Escape takes it back; else what was typed stays, and says that it is not sent. */
function SetField({ device, field, value }: { device: string; field: string; value: number | null | undefined }) {
  const typed = ownOf(unsent.of(device), field) ?? null;
  const setTyped = (text: string) => unsent.put(device, { ...unsent.of(device), [field]: text });
  const putAway = () => {
    const { [field]: _, ...others } = unsent.of(device);
    unsent.put(device, others);
  };
  const id = useId();
  const checked = check({ name: field }, typed ?? "");
  const problem = typed === null || "value" in checked ? "" : "problem" in checked ? checked.problem : "write a number";
  const send = async () => {
    if (typed === null || !("value" in checked)) return;
    try {
      await link.ask("set", device, { field, value: checked.value });
      if (ownOf(unsent.of(device), field) === typed) putAway();
    } catch (error) {
      notifyError(error);
    }
  };
  return (
    <>
      <input
        class="mono is-number"
        aria-label={`Set ${field}`}
        aria-invalid={problem !== ""}
        aria-describedby={typed === null ? undefined : id}
        inputMode="decimal"
        value={typed ?? (value === null || value === undefined ? "" : String(Number(value.toPrecision(7))))}
        onFocus={(event) => typed === null && event.currentTarget.select()}
        onInput={(event) => setTyped(event.currentTarget.value)}
        onKeyDown={(event) => {
          if (event.key === "Enter") void send();
          if (event.key === "Escape") putAway();
        }}
      />
      {typed !== null && (
        <small id={id} class={problem ? "problem set-note" : "soft set-note"}>
          {problem || "Enter sends it"}
        </small>
      )}
    </>
  );
}
