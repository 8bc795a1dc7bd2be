/** Plots of signals: a pane for each unit, one time axis, cursors, and what can be done with them. */

import { useEffect, useRef } from "preact/hooks";
import { timesText } from "../../model/fault_marks";
import { plotMarks, shownFaults } from "../../past";
import { whenLoaded } from "../../parts/when_loaded";
import { theme } from "../../theme";
import { feedOf } from "./axis_feed";
import { neededFields } from "./axis_fields";
import { CursorsTable } from "./cursors_table";
import { PaneView } from "./pane_view";
import { Controls } from "./plot_controls";
import type { PlotPane } from "./plot_pane";
import type { PlotModel } from "./plot_model";
import { wantedOf } from "./plot_save";
import type { XyPane } from "./xy_pane";
import "./plots.css";

const XyView = whenLoaded(async () => (await import("./xy_view")).XyView);
const KEY_STEP = 0.01;

/** `isFilling`: the panes share the height of what they stand in. */
export function Plots({ model, isFilling = false }: { model: PlotModel; isFilling?: boolean }) {
  const chosen = model.chosen.value;
  const others = model.others.value;
  const panes = model.panes();
  const made = useRef(new Map<string, PlotPane>());
  const xy = useRef<XyPane | null>(null);
  useMarks(model);
  useEffect(() => model.feed.want(neededFields(model.device, chosen), true), [model, chosen.join(" ")]);
  useEffect(() => wantBeside(model), [model, others.join(" ")]);
  useEffect(() => {
    for (const axis of wantedOf(model).keys()) feedOf(axis).lookBackOver(model.window_s.value);
  }, [model, model.window_s.value, others.join(" ")]);
  const isNarrow = panes.some(({ rightUnit }) => rightUnit !== undefined);
  return (
    <section class={isFilling ? "plots is-filling" : "card plots"} aria-label={`Plots of ${model.id}`}>
      <Controls model={model} made={made.current} panes={panes} xy={xy} />
      {model.feed.refusal.value && <p class="problem">{model.feed.refusal.value}</p>}
      <div
        class="panes"
        style={{ "--panes": Math.max(panes.length, 1) }}
        role="group"
        tabIndex={0}
        aria-label="Plots. Space pauses, plus and minus zoom, arrow keys move cursor A, with Shift cursor B, page up and down move the time, Home shows the present."
        onKeyDown={(event) => onKey(event, model)}
        onWheel={(event) => onWheel(event, model)}
      >
        {panes.length === 0 && <p class="empty">No field is chosen.</p>}
        {panes.map((pane, at) => (
          <PaneView
            key={`${pane.key} ${pane.fields.map((field) => `${field.name}${field.isRight ? ">" : ""}`).join(" ")} ${theme.value}`}
            pane={pane}
            model={model}
            isFirst={at === 0}
            hasTimes={at === panes.length - 1}
            isNarrow={isNarrow}
            made={made.current}
          />
        ))}
      </div>
      {model.xy.value && <XyView model={model} choice={model.xy.value} made={xy} />}
      <CursorsTable model={model} />
      <FaultTimes model={model} />
    </section>
  );
}

/** Want fields of other axes; answers the function that ends it. */
function wantBeside(model: PlotModel): () => void {
  const ends = [...wantedOf(model)].filter(([axis]) => axis !== model.axis).map(([axis, fields]) => feedOf(axis).want(fields, true));
  return () => {
    for (const end of ends) end();
  };
}

/** Zoom with Ctrl; a wheel to the side, or with Shift, moves the time. */
function onWheel(event: WheelEvent & { currentTarget: HTMLElement }, model: PlotModel): void {
  const isAcross = Math.abs(event.deltaX) > Math.abs(event.deltaY);
  if (!event.ctrlKey && !isAcross) return;
  event.preventDefault();
  if (event.ctrlKey) model.zoom(event.deltaY < 0 ? 0.8 : 1.25);
  else model.pan(event.deltaX / event.currentTarget.clientWidth);
}

function onKey(event: KeyboardEvent, model: PlotModel): void {
  const actions: Record<string, () => void> = {
    " ": () => model.togglePause(),
    "+": () => model.zoom(0.5),
    "=": () => model.zoom(0.5),
    "-": () => model.zoom(2),
    ArrowLeft: () => model.moveCursor(event.shiftKey, -KEY_STEP),
    ArrowRight: () => model.moveCursor(event.shiftKey, KEY_STEP),
    PageUp: () => model.pan(-0.5),
    PageDown: () => model.pan(0.5),
    Home: () => model.toPresent(),
  };
  const action = actions[event.key];
  if (!action || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  action();
}

const MOST_TIMES = 4;

/** Times of the last faults that stand on the plots, as text. */
function FaultTimes({ model }: { model: PlotModel }) {
  const marks = shownFaults.value.slice(-MOST_TIMES);
  if (!marks.length) return null;
  return (
    <ul class="fault-times soft" aria-label={`Faults on the plots of ${model.id}`}>
      {marks.map((mark) => (
        <li key={mark.number}>
          <span class="mono">{mark.kind}</span> on {mark.target}: {timesText(mark)}
        </li>
      ))}
    </ul>
  );
}

/** Draw again when there are other marks, although a plot may be paused. */
function useMarks(model: PlotModel): void {
  const [faults, marks] = [shownFaults.value, plotMarks.value];
  useEffect(() => {
    model.changes++;
  }, [faults, marks]);
}
