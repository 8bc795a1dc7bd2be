/** The bench at a glance: a card for each axis, segment, bus and door, what is wrong first, and three things to try. */

import { computed } from "@preact/signals";
import { keptText } from "../../kept";
import { type AxisCard, inOrder } from "../../model/axis_card";
import { devices, status } from "../../store";
import { AxisCardView } from "./axis_card_view";
import { cardFor } from "./figures";
import { FirstSteps, stepsKept } from "./first_steps_view";
import { DoorCard, hasTrouble, WireCard } from "./wire_cards";
import "./overview.css";

/** Cards of a bench from which on they are small, unless somebody chooses. */
const MANY = 24;
const FEW = 4;

const filter = keptText("overview.filter");
const density = keptText("overview.density");

const cards = computed(() => [...devices.value.values()].map(cardFor));

export function Overview() {
  const all = cards.value;
  const { wires, doors } = status.value;
  const isDense = density.value === "" ? all.length > MANY : density.value === "dense";
  const wanted = filter.value.trim().toLowerCase();
  const fits = (name: string) => name.toLowerCase().includes(wanted);
  const axes = inOrder(all, filter.value);
  const shownWires = wires.filter(({ name }) => fits(name));
  const bad = shownWires.filter(hasTrouble);
  const good = shownWires.filter((wire) => !hasTrouble(wire));
  const shownDoors = doors.filter(({ name }) => fits(name));
  const count = axes.length + shownWires.length + shownDoors.length;
  const size = isDense ? " is-dense" : count <= FEW ? " is-few" : "";
  return (
    <>
      <div class="row overview-bar">
        <input
          type="search"
          placeholder="filter"
          aria-label="Filter the cards by name, kind or state"
          value={filter.value}
          onInput={(event) => (filter.value = event.currentTarget.value)}
        />
        <button type="button" aria-pressed={isDense} onClick={() => (density.value = isDense ? "wide" : "dense")}>
          Small cards
        </button>
        {stepsKept.value && (
          <button type="button" onClick={() => (stepsKept.value = "")}>
            Things to try
          </button>
        )}
        <span class="soft" role="status">
          {wanted ? `${count} of ${all.length + wires.length + doors.length}` : ""}
        </span>
      </div>
      <FirstSteps isShort={isDense} />
      {all.length === 0 && <p class="empty">This bench has no devices.</p>}
      {wanted !== "" && count === 0 && <p class="empty">Nothing here has “{filter.value}” in its name.</p>}
      <ul class={`cards${size}`} aria-label="Cards of the bench">
        {bad.map((wire) => (
          <li key={`wire ${wire.name}`}>
            <WireCard wire={wire} />
          </li>
        ))}
        {axes.map((card: AxisCard) => (
          <li key={card.name}>
            <AxisCardView card={card} />
          </li>
        ))}
        {good.map((wire) => (
          <li key={`wire ${wire.name}`}>
            <WireCard wire={wire} />
          </li>
        ))}
        {shownDoors.map((door) => (
          <li key={`door ${door.name}`}>
            <DoorCard door={door} />
          </li>
        ))}
      </ul>
    </>
  );
}
