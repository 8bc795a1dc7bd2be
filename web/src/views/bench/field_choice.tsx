/** Choice of the fields that plots draw: the axis's own, and those of other axes. */

import { useState } from "preact/hooks";
import type { FieldRow } from "../../model/door";
import { devices } from "../../store";
import { drawable, fieldsBeside } from "./axis_fields";
import type { PlotModel } from "./plot_model";

export function FieldChoice({ model }: { model: PlotModel }) {
  const [isOpen, setOpen] = useState(false);
  const [axis, setAxis] = useState("");
  const chosen = model.chosen.value;
  const others = model.others.value.map(({ name }) => name);
  const axes = [...devices.value.values()].filter((device) => device.name !== model.axis && device.fields.length > 0);
  const other = axes.find((device) => device.name === axis);
  return (
    <div class="field-choice">
      <button type="button" aria-expanded={isOpen} onClick={() => setOpen(!isOpen)}>
        Fields ({chosen.length + others.length})
      </button>
      {isOpen && (
        <div class="field-list" role="group" aria-label="Fields to draw" onKeyDown={(event) => event.key === "Escape" && setOpen(false)}>
          {drawable(model.device).map((field) => (
            <Choice key={field.name} field={field} isChosen={chosen.includes(field.name)} onToggle={() => model.toggleField(field.name)} />
          ))}
          {axes.length > 0 && (
            <label>
              <span class="soft">and of</span>
              <select value={axis} onChange={(event) => setAxis(event.currentTarget.value)}>
                <option value="">another device</option>
                {axes.map(({ name }) => (
                  <option key={name} value={name}>
                    {name}
                  </option>
                ))}
              </select>
            </label>
          )}
          {other &&
            fieldsBeside(other).map((field) => (
              <Choice key={field.name} field={field} isChosen={others.includes(field.name)} onToggle={() => model.toggleOther(field)} />
            ))}
        </div>
      )}
    </div>
  );
}

function Choice({ field, isChosen, onToggle }: { field: FieldRow; isChosen: boolean; onToggle: () => void }) {
  return (
    <label title={field.meaning}>
      <input type="checkbox" checked={isChosen} onChange={onToggle} />
      <span class="mono">{field.name}</span>
      {field.unit && <span class="soft"> {field.unit}</span>}
    </label>
  );
}
