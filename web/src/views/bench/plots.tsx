/** The plots of an axis: a pane for each unit, one time axis, cursors, and what can be done with them. */

import { useEffect, useRef } from "preact/hooks";
import type { FieldRow } from "../../model/door";
import { timesText } from "../../model/fault_marks";
import { digitsOf, shown } from "../../model/numbers";
import { csvOf } from "../../model/samples_csv";
import { type Layer, samplingText } from "../../model/sampling";
import { notify, notifyError } from "../../parts/notices";
import { shownFaults, trouble } from "../../past";
import { theme } from "../../theme";
import { feedOf } from "./axis_feed";
import { besideOf, isByMode, neededFields, panesOf, type Pane, unitIn } from "./axis_fields";
import { download, fileName, pngOf } from "./export";
import { FieldChoice } from "./field_choice";
import { allOf } from "./past_samples";
import { PlotPane } from "./plot_pane";
import { type PlotModel, WINDOWS_s } from "./plot_model";
import { ValueRange } from "./value_range";

const VALUES_EVERY_MS = 100;
const KEY_STEP = 0.01;

export function Plots({ model }: { model: PlotModel }) {
  const chosen = model.chosen.value;
  const others = model.others.value;
  const panes = panesOf(model.device, chosen, model.feed.modes.value, others);
  const made = useRef(new Map<string, PlotPane>());
  useEffect(() => model.feed.want(neededFields(model.device, chosen), true), [model, chosen.join(" ")]);
  useEffect(() => wantBeside(others, model.window_s.peek()), [model, others]);
  useEffect(() => {
    model.feed.lookBackOver(model.window_s.value);
    for (const { name } of others) feedOf(besideOf(name)?.axis ?? model.axis).lookBackOver(model.window_s.value);
  }, [model, model.window_s.value, others]);
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
            isFirst={at === 0}
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

/** Want fields of other axes; answers the function that ends it. */
function wantBeside(others: FieldRow[], window_s: number): () => void {
  const ends = others.map(({ name }) => {
    const { axis, field } = besideOf(name)!;
    feedOf(axis).lookBackOver(window_s);
    return feedOf(axis).want([field], true);
  });
  return () => {
    for (const end of ends) end();
  };
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
  const save = (layer: Layer, columnOf: (name: string) => number, from_s: number, to_s: number) => {
    const own = neededFields(model.device, model.chosen.peek()).map((name) => ({ name, units: unitsOf(model, name), column: columnOf(name) }));
    const others = model.others.peek().map(({ name, unit }) => {
      const { ring, column } = model.placeOf(name, from_s);
      return { name, units: [unit], column, of: ring };
    });
    const fields = [...own, ...others];
    const csv = csvOf(layer, fields, from_s, to_s);
    download(fileName(model.axis, "csv"), new Blob([csv], { type: "text/csv" }));
  };
  const saveShown = () => {
    const now_ms = performance.now();
    save(model.shownLayer(now_ms), (name) => model.feed.column(name), model.left_s(now_ms), model.right_s(now_ms));
  };
  const saveAll = async () => {
    const now_ms = performance.now();
    const [from_s, to_s] = [model.left_s(now_ms), model.right_s(now_ms)];
    const names = neededFields(model.device, model.chosen.peek());
    try {
      const layer = await allOf(model.axis, names, from_s, to_s);
      if (layer) save(layer, (name) => names.indexOf(name) + 1, from_s, to_s);
      else notify(trouble.peek() || "the recording has nothing of this time", true);
    } catch (error) {
      notifyError(error);
    }
  };
  const savePng = async () => {
    const inOrder = panes.map((pane) => made.get(pane.key)).filter((pane) => pane !== undefined);
    const title = `${model.axis}: ${samplingText(model.shownLayer(performance.now()).sampling)}`;
    const png = inOrder.length ? await pngOf(title, inOrder) : null;
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
        <select
          value={isPaused ? "" : String(model.window_s.value)}
          disabled={isPaused}
          onChange={(event) => (model.window_s.value = Number(event.currentTarget.value))}
        >
          {isPaused && <option value="">{Number((model.to_s.value - model.from_s.value).toPrecision(3))} s</option>}
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
        <button type="button" title="The rows that are shown" onClick={saveShown}>
          CSV
        </button>
        <button
          type="button"
          title="Each control step of what is shown, from the recording of the run; of more than some seconds the smallest and the largest values"
          onClick={() => void saveAll()}
        >
          CSV, all steps
        </button>
        <button type="button" onClick={() => void savePng()}>
          PNG
        </button>
      </span>
    </div>
  );
}

/** Units that the values of a field have had. */
function unitsOf(model: PlotModel, name: string): string[] {
  const unit = model.device.fields.find((field) => field.name === name)?.unit ?? "";
  const byMode = isByMode(model.device, name) ? [...new Set(model.feed.modes.peek().map(unitIn))] : [];
  return byMode.length ? byMode : [unit];
}

interface PaneProps {
  pane: Pane;
  model: PlotModel;
  isFirst: boolean;
  hasTimes: boolean;
  made: Map<string, PlotPane>;
}

function PaneView({ pane, model, isFirst, hasTimes, made }: PaneProps) {
  const place = useRef<HTMLDivElement>(null);
  const values = useRef<(HTMLElement | null)[]>([]);
  const sampling = useRef<HTMLElement>(null);
  useEffect(() => {
    if (!place.current) return;
    const drawn = new PlotPane(place.current, pane, model, isFirst, hasTimes);
    made.set(pane.key, drawn);
    const endClicks = cursorsByClicks(drawn, model);
    const tell = () => {
      tellValues(drawn, pane, model, values.current);
      if (sampling.current) write(sampling.current, samplingText(model.shownLayer(performance.now()).sampling));
    };
    tell();
    const timer = window.setInterval(tell, VALUES_EVERY_MS);
    return () => {
      window.clearInterval(timer);
      endClicks();
      if (made.get(pane.key) === drawn) made.delete(pane.key);
      drawn.end();
    };
  }, [isFirst, hasTimes]);
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
        <span class="push row pane-range">
          {isFirst && <span class="soft mono" ref={sampling} title="How the samples that are drawn were made" />}
          <ValueRange pane={pane} model={model} made={made} />
        </span>
      </div>
      <div class="pane-plot" ref={place} />
    </div>
  );
}

function write(place: HTMLElement, text: string): void {
  if (place.textContent !== text) place.textContent = text;
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
  const at_s = drawn.hovered_s() ?? (model.paused.peek() ? model.to_s.peek() : model.layers[0]!.ring.last_s);
  pane.fields.forEach((field, at) => {
    const text = shown(model.valueAt(field.name, at_s, field.unit), digitsOf(field.unit));
    const place = places[at];
    if (place) write(place, text);
  });
}

/** Values at the cursors, and their differences. */
function Cursors({ model }: { model: PlotModel }) {
  const a = model.cursorA.value;
  const b = model.cursorB.value;
  if ((a === null && b === null) || !model.isPaused.value) {
    return <p class="soft hint">Click: cursor A. Shift and click: cursor B. Drag: zoom. Double click: live.</p>;
  }
  const fields = [...model.device.fields.filter((field) => model.chosen.value.includes(field.name)), ...model.others.value];
  const value = (name: string, at: number | null) => (at === null ? NaN : model.valueAtCursor(name, at));
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
  const marks = shownFaults.value.slice(-MOST_TIMES);
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
  const marks = shownFaults.value;
  useEffect(() => {
    model.changes++;
  }, [marks]);
}
