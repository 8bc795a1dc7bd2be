/** Choice of the fields that plots draw, of the axis and of others, and of the axes of panes where they stand. */

import { useId, useRef, useState } from "preact/hooks";
import type { FieldRow } from "../../model/door";
import { devices } from "../../store";
import { drawable, fieldsBeside, type Pane } from "./axis_fields";
import type { PlotModel } from "./plot_model";

const GAP_PX = 4;

export function FieldChoice({ model, panes }: { model: PlotModel; panes: Pane[] }) {
  const list = useRef<HTMLDivElement>(null);
  const button = useRef<HTMLButtonElement>(null);
  const [isOpen, setOpen] = useState(false);
  const id = useId();
  const count = model.chosen.value.length + model.others.value.length;
  const toggled = (event: { newState: string }) => {
    setOpen(event.newState === "open");
    if (event.newState === "open" && button.current && list.current) place(list.current, button.current);
  };
  return (
    <>
      <button type="button" ref={button} popovertarget={id} aria-expanded={isOpen}>
        Fields ({count})
      </button>
      <div ref={list} id={id} popover="auto" class="field-list" role="group" aria-label="Fields to draw" onToggle={toggled}>
        {isOpen && <Choices model={model} panes={panes} />}
      </div>
    </>
  );
}

/** Put the list below its button, inside of the window. */
function place(list: HTMLElement, button: HTMLElement): void {
  const { left, bottom } = button.getBoundingClientRect();
  const room = document.documentElement.clientWidth - list.offsetWidth - GAP_PX;
  list.style.left = `${Math.max(Math.min(left, room), GAP_PX)}px`;
  list.style.top = `${bottom + GAP_PX}px`;
  list.style.maxHeight = `${Math.max(window.innerHeight - bottom - 3 * GAP_PX, 160)}px`;
}

function Choices({ model, panes }: { model: PlotModel; panes: Pane[] }) {
  const [axis, setAxis] = useState("");
  const chosen = model.chosen.value;
  const others = model.others.value;
  const axes = [...devices.value.values()].filter((device) => device.name !== model.axis && device.fields.length > 0);
  const other = axes.find((device) => device.name === axis);
  const shown = model.otherFields();
  const rows = other ? fieldsBeside(other).filter(({ name }) => !others.includes(name)) : [];
  return (
    <>
      <p class="soft">of {model.axis}</p>
      {drawable(model.device).map((field) => (
        <Choice
          key={field.name}
          field={field}
          isChosen={chosen.includes(field.name)}
          onToggle={() => model.toggleField(field.name)}
          model={model}
          panes={panes}
        />
      ))}
      {shown.length > 0 && <p class="soft">of other devices</p>}
      {shown.map((field) => (
        <Choice key={field.name} field={field} isChosen onToggle={() => model.toggleOther(field.name)} model={model} panes={panes} />
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
      {rows.map((field) => (
        <Choice key={field.name} field={field} isChosen={false} onToggle={() => model.toggleOther(field.name)} model={model} panes={panes} />
      ))}
    </>
  );
}

interface ChoiceProps {
  field: FieldRow;
  isChosen: boolean;
  onToggle: () => void;
  model: PlotModel;
  panes: Pane[];
}

function Choice({ field, isChosen, onToggle, model, panes }: ChoiceProps) {
  return (
    <div class="row field-row">
      <label title={field.meaning}>
        <input type="checkbox" checked={isChosen} onChange={onToggle} />
        <span class="mono">{field.name}</span>
        {field.unit && <span class="soft"> {field.unit}</span>}
      </label>
      {isChosen && <AxisChoice name={field.name} model={model} panes={panes} />}
    </div>
  );
}

/** Choice of the pane at whose right axis a field is drawn: its own, or one that has none of another unit there. */
function AxisChoice({ name, model, panes }: { name: string; model: PlotModel; panes: Pane[] }) {
  const pane = panes.find(({ fields }) => fields.some((field) => field.name === name));
  const field = pane?.fields.find((each) => each.name === name);
  const free = panes.filter(
    ({ key, unit, rightUnit, fields }) =>
      key === pane?.key || (unit !== field?.unit && (rightUnit ?? field?.unit) === field?.unit && fields.some(({ isRight }) => !isRight)),
  );
  const others = free.filter(({ key }) => field?.isRight || key !== pane?.key);
  if (!pane || !field || !others.length) return null;
  return (
    <select
      class="push"
      aria-label={`Axis of ${name}`}
      value={field.isRight ? pane.key : ""}
      onChange={(event) => model.moveRight(name, event.currentTarget.value)}
    >
      <option value="">own axis</option>
      {others.map(({ key, title }) => (
        <option key={key} value={key}>
          right of {title.toLowerCase()}
        </option>
      ))}
    </select>
  );
}
