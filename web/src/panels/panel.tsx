/** One panel: what it shows, or why it cannot; its settings, and what can be done with it. */

import { useId } from "preact/hooks";
import type { PanelRow } from "../model/layout";
import { Guarded } from "../parts/guarded";
import { Menu } from "../parts/menu";
import { changePanel, layout, rowOf, settingsOf } from "./desk";
import type { Dock } from "./dock";
import { isThere, KINDS, titleOf } from "./kinds";

export function PanelBody({ id }: { id: string }) {
  const row = rowOf(id);
  if (!row) return null;
  const { Body, Settings = Target, title, isControl } = KINDS[row.kind];
  const { isWatch } = layout.value;
  if (isWatch && isControl) return <p class="empty">{title} changes the bench: this layout has no controls.</p>;
  const isHere = isThere(row);
  return (
    <div class={`panel is-${row.kind}`} role="group" aria-label={titleOf(row)} tabIndex={0}>
      {!isHere && (
        <p class="problem" role="status">
          {row.of || title} is not on this bench. The panel stays for when it comes; or choose another:
        </p>
      )}
      {(!isHere || settingsOf.value === id) && (
        <div class="row panel-settings" role="group" aria-label={`Settings of ${titleOf(row)}`}>
          <Settings row={row} />
        </div>
      )}
      {isHere && (
        <Guarded>
          <Body key={row.of} row={row} isWatch={isWatch} />
        </Guarded>
      )}
    </div>
  );
}

/** Choice of what a panel shows. */
function Target({ row }: { row: PanelRow }) {
  const targets = KINDS[row.kind].targets?.() ?? [];
  if (!KINDS[row.kind].targets) return <span class="soft">This panel shows the whole bench: there is nothing to choose.</span>;
  return <Choice label="Shows" value={row.of} options={targets} onChange={(of) => changePanel(row.id, { of })} />;
}

interface ChoiceProps {
  label: string;
  value: string;
  options: readonly string[];
  onChange(value: string): void;
}

/** Choice of one of some texts; a value that is none of them is shown as such. */
export function Choice({ label, value, options, onChange }: ChoiceProps) {
  const id = useId();
  return (
    <span class="row">
      <label htmlFor={id}>{label}</label>
      <select id={id} value={value} onChange={(event) => onChange(event.currentTarget.value)}>
        {!options.includes(value) && <option value={value}>{value ? `${value} (missing)` : "choose"}</option>}
        {options.map((each) => (
          <option key={each}>{each}</option>
        ))}
      </select>
    </span>
  );
}

/** Whether a panel has something that can be chosen. */
export function hasSettings(row: PanelRow): boolean {
  const { Settings, targets } = KINDS[row.kind];
  return Settings !== undefined || (targets?.().length ?? 0) > 1;
}

export function toggleSettings(id: string): void {
  settingsOf.value = settingsOf.peek() === id ? "" : id;
}

/** Buttons of a panel in the dock. */
export function PanelActions({ id, dock }: { id: string; dock: Dock }) {
  const row = rowOf(id);
  if (!row) return null;
  const title = titleOf(row);
  const act = (text: string, work: () => void, key = "") => (
    <button type="button" data-closes onClick={work}>
      <span>{text}</span> {key && <kbd>{key}</kbd>}
    </button>
  );
  return (
    <>
      {hasSettings(row) && (
        <button
          type="button"
          class="plain"
          aria-pressed={settingsOf.value === id}
          aria-label={`Settings of ${title}`}
          title="Settings"
          onClick={() => toggleSettings(id)}
        >
          ⚙
        </button>
      )}
      <Menu text="⋯" label={`Arrange ${title}`} class="plain">
        {act("Move left", () => dock.move(id, "left"), "Alt ←")}
        {act("Move right", () => dock.move(id, "right"), "Alt →")}
        {act("Move up", () => dock.move(id, "above"), "Alt ↑")}
        {act("Move down", () => dock.move(id, "below"), "Alt ↓")}
        {act("Behind a neighbour, as a tab", () => dock.asTab(id))}
        {act("Before the tab before it", () => dock.reorder(id, -1), "Alt Page up")}
        {act("Behind the next tab", () => dock.reorder(id, 1), "Alt Page down")}
        {act("Wider", () => dock.resize(id, 1, 0), "Shift →")}
        {act("Narrower", () => dock.resize(id, -1, 0), "Shift ←")}
        {act("Taller", () => dock.resize(id, 0, 1), "Shift ↓")}
        {act("Lower", () => dock.resize(id, 0, -1), "Shift ↑")}
        {act("Fill the room, or no longer", () => dock.fill(id), "Enter")}
      </Menu>
      <button type="button" class="plain" aria-label={`Close ${title}`} title="Close (Delete on the tab)" onClick={() => dock.close(id)}>
        ×
      </button>
    </>
  );
}
