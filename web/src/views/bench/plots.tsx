/** The plots of an axis: a pane for each unit, one time axis, cursors, and what can be done with them. */

import { useEffect, useRef, useState } from "preact/hooks";
import { timesText } from "../../model/fault_marks";
import { digitsOf, shown } from "../../model/numbers";
import { notify } from "../../parts/notices";
import { faultMarks } from "../../store";
import { theme } from "../../theme";
import { drawable, neededFields, panesOf, type Pane } from "./axis_fields";
import { csvOf, download, fileName, pngOf } from "./export";
import { PlotPane } from "./plot_pane";
import { type PlotModel, WINDOWS_s } from "./plot_model";

const VALUES_EVERY_MS = 100;
const KEY_STEP = 0.01;

export function Plots({ model }: { model: PlotModel }) {
  const chosen = model.chosen.value;
  const panes = panesOf(model.device, chosen, model.feed.modes.value);
  const made = useRef(new Map<string, PlotPane>());
  useEffect(() => model.feed.want(neededFields(model.device, chosen)), [model, chosen.join(" ")]);
  const isWithout = panes.length === 0;
  return (
    <section class="card plots" aria-label={`Plots of ${model.axis}`}>
      <Controls model={model} made={made.current} panes={panes} />
      {model.feed.refusal.value && <p class="problem">{model.feed.refusal.value}</p>}
      <div
        class="panes"
        role="group"
        tabIndex={0}
        aria-label="Plots. Space pauses, plus and minus zoom, arrow keys move cursor A, with Shift cursor B, Home shows the present."
        onKeyDown={(event) => onKey(event, model)}
        onWheel={(event) => event.ctrlKey && (event.preventDefault(), model.zoom(event.deltaY < 0 ? 0.8 : 1.25))}
      >
        {isWithout && <p class="empty">No field is chosen.</p>}
        {panes.map((pane, at) => (
          <PaneView
            key={`${pane.key} ${pane.fields.map((field) => field.name).join(" ")} ${theme.value}`}
            pane={pane}
            model={model}
            hasTimes={at === panes.length - 1}
            made={made.current}
          />
        ))}
      </div>
      <Cursors model={model} />
      <FaultTimes model={model} />
    </section>
  );
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
    Home: () => model.live(),
  };
  const action = actions[event.key];
  if (!action || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  action();
}

function Controls({ model, made, panes }: { model: PlotModel; made: Map<string, PlotPane>; panes: Pane[] }) {
  const isPaused = model.isPaused.value;
  const saveCsv = () => {
    const fields = neededFields(model.device, model.chosen.peek()).map((name) => ({ name, column: model.feed.column(name) }));
    const now_ms = performance.now();
    const csv = csvOf(model.ring, fields, model.left_s(now_ms), model.right_s(now_ms));
    download(fileName(model.axis, "csv"), new Blob([csv], { type: "text/csv" }));
  };
  const savePng = async () => {
    const inOrder = panes.map((pane) => made.get(pane.key)).filter((pane) => pane !== undefined);
    const png = inOrder.length ? await pngOf(model.axis, inOrder) : null;
    if (png) download(fileName(model.axis, "png"), png);
    else notify("there is no plot to save", true);
  };
  return (
    <div class="card-head">
      <h3>Plots</h3>
      <button type="button" aria-pressed={isPaused} onClick={() => model.togglePause()}>
        {isPaused ? "Paused" : "Pause"}
      </button>
      <label>
        <span class="out-of-sight">Shown time</span>
        <select value={String(model.window_s.value)} disabled={isPaused} onChange={(event) => (model.window_s.value = Number(event.currentTarget.value))}>
          {WINDOWS_s.map((window_s) => (
            <option key={window_s} value={String(window_s)}>
              {window_s} s
            </option>
          ))}
        </select>
      </label>
      <button type="button" aria-label="Zoom in" title="Zoom in (+)" onClick={() => model.zoom(0.5)}>
        +
      </button>
      <button type="button" aria-label="Zoom out" title="Zoom out (−)" onClick={() => model.zoom(2)}>
        −
      </button>
      {isPaused && (
        <>
          <button type="button" aria-label="Earlier" title="Earlier (Page up)" onClick={() => model.pan(-0.5)}>
            ◂
          </button>
          <button type="button" aria-label="Later" title="Later (Page down)" onClick={() => model.pan(0.5)}>
            ▸
          </button>
          <button type="button" class="primary" title="Back to the present (Home)" onClick={() => model.live()}>
            Live
          </button>
        </>
      )}
      <FieldChoice model={model} />
      <span class="push row">
        {model.feed.lost.value > 0 && <span class="soft">{model.feed.lost.value} samples lost</span>}
        <button type="button" onClick={saveCsv}>
          CSV
        </button>
        <button type="button" onClick={() => void savePng()}>
          PNG
        </button>
      </span>
    </div>
  );
}

function FieldChoice({ model }: { model: PlotModel }) {
  const [isOpen, setOpen] = useState(false);
  const chosen = model.chosen.value;
  return (
    <div class="field-choice">
      <button type="button" aria-expanded={isOpen} onClick={() => setOpen(!isOpen)}>
        Fields ({chosen.length})
      </button>
      {isOpen && (
        <div class="field-list" role="group" aria-label="Fields to draw" onKeyDown={(event) => event.key === "Escape" && setOpen(false)}>
          {drawable(model.device).map((field) => (
            <label key={field.name} title={field.meaning}>
              <input type="checkbox" checked={chosen.includes(field.name)} onChange={() => model.toggleField(field.name)} />
              <span class="mono">{field.name}</span>
              {field.unit && <span class="soft"> {field.unit}</span>}
            </label>
          ))}
        </div>
      )}
    </div>
  );
}

interface PaneProps {
  pane: Pane;
  model: PlotModel;
  hasTimes: boolean;
  made: Map<string, PlotPane>;
}

function PaneView({ pane, model, hasTimes, made }: PaneProps) {
  const place = useRef<HTMLDivElement>(null);
  const values = useRef<(HTMLElement | null)[]>([]);
  useEffect(() => {
    if (!place.current) return;
    const drawn = new PlotPane(place.current, pane, model, hasTimes);
    made.set(pane.key, drawn);
    const endClicks = cursorsByClicks(drawn, model);
    const timer = window.setInterval(() => tellValues(drawn, pane, model, values.current), VALUES_EVERY_MS);
    return () => {
      window.clearInterval(timer);
      endClicks();
      if (made.get(pane.key) === drawn) made.delete(pane.key);
      drawn.end();
    };
  }, [hasTimes]);
  return (
    <div class={hasTimes ? "pane has-times" : "pane"}>
      <div class="pane-legend">
        <span class="soft">
          {pane.title}
          {pane.unit && ` (${pane.unit})`}
        </span>
        {pane.fields.map((field, at) => (
          <span key={field.name} class={`trace trace-${(at % 6) + 1}`} title={field.meaning}>
            {field.name} <span class="mono trace-value" ref={(element) => void (values.current[at] = element)} />
          </span>
        ))}
      </div>
      <div class="pane-plot" ref={place} />
    </div>
  );
}

/** Set cursor A by a click into the plot, B by a click with Shift; a drag is a zoom. */
function cursorsByClicks(drawn: PlotPane, model: PlotModel): () => void {
  const over = drawn.plot.over;
  let down = 0;
  const onDown = (event: MouseEvent) => (down = event.clientX);
  const onClick = (event: MouseEvent) => {
    const time_s = drawn.hovered_s();
    if (Math.abs(event.clientX - down) < 4 && time_s !== null && event.detail < 2) model.setCursor(event.shiftKey, time_s);
  };
  over.addEventListener("mousedown", onDown);
  over.addEventListener("click", onClick);
  return () => {
    over.removeEventListener("mousedown", onDown);
    over.removeEventListener("click", onClick);
  };
}

/** Write the values at the mouse, or the newest, beside the names. */
function tellValues(drawn: PlotPane, pane: Pane, model: PlotModel, places: (HTMLElement | null)[]): void {
  const ring = model.ring;
  const at_s = drawn.hovered_s() ?? (model.paused.peek() ? model.to_s.peek() : ring.last_s);
  pane.fields.forEach((field, at) => {
    const text = shown(model.valueAt(field.name, at_s, field.unit), digitsOf(field.unit));
    const place = places[at];
    if (place && place.textContent !== text) place.textContent = text;
  });
}

/** Values at the cursors, and their differences. */
function Cursors({ model }: { model: PlotModel }) {
  const a = model.cursorA.value;
  const b = model.cursorB.value;
  if ((a === null && b === null) || !model.isPaused.value) {
    return <p class="soft hint">Click: cursor A. Shift and click: cursor B. Drag: zoom. Double click: live.</p>;
  }
  const fields = model.device.fields.filter((field) => model.chosen.value.includes(field.name));
  const value = (name: string, at: number | null) => (at === null ? NaN : model.valueAt(name, at));
  const rows = fields.map((field) => {
    const units = [a, b].filter((at) => at !== null).map((at) => model.unitAt(field.name, at, field.unit));
    const isOne = new Set(units).size === 1;
    const by = isOne ? value(field.name, b) - value(field.name, a) : NaN;
    return { name: field.name, unit: [...new Set(units)].join(", "), digits: digitsOf(units[0] ?? field.unit), by };
  });
  return (
    <div class="scroll-x" role="region" aria-label="Values at the cursors" tabIndex={0}>
      <table class="cursors">
        <thead>
          <tr>
            <th scope="col">field</th>
            <th scope="col" class="num">
              A
            </th>
            <th scope="col" class="num">
              B
            </th>
            <th scope="col" class="num">
              B − A
            </th>
            <th scope="col">unit</th>
          </tr>
        </thead>
        <tbody>
          <tr>
            <th scope="row">time</th>
            <td class="num">{shown(a, 4)}</td>
            <td class="num">{shown(b, 4)}</td>
            <td class="num">{a !== null && b !== null ? shown(b - a, 4) : "–"}</td>
            <td>s</td>
          </tr>
          {rows.map(({ name, unit, digits, by }) => (
            <tr key={name}>
              <th scope="row">{name}</th>
              <td class="num">{shown(value(name, a), digits)}</td>
              <td class="num">{shown(value(name, b), digits)}</td>
              <td class="num">{shown(by, digits)}</td>
              <td>{unit}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

const MOST_TIMES = 4;

/** Times of the last faults that stand on the plots, as text. */
function FaultTimes({ model }: { model: PlotModel }) {
  const marks = faultMarks.value.slice(-MOST_TIMES);
  if (!marks.length) return null;
  return (
    <ul class="fault-times soft" aria-label={`Faults on the plots of ${model.axis}`}>
      {marks.map((mark) => (
        <li key={mark.number}>
          <span class="mono">{mark.kind}</span> on {mark.target}: {timesText(mark)}
        </li>
      ))}
    </ul>
  );
}

/** Draw again when the faults change, although a plot may be paused. */
export function useMarks(model: PlotModel): void {
  const marks = faultMarks.value;
  useEffect(() => {
    model.changes++;
  }, [marks]);
}
