/** What can be done with plots: pause, time that is shown, fields, files. */

import { useState } from "preact/hooks";
import type { Pane } from "./axis_fields";
import { FieldChoice } from "./field_choice";
import type { PlotPane } from "./plot_pane";
import { type PlotModel, WINDOWS_s } from "./plot_model";
import { saveAll, savePng, saveShown } from "./plot_save";
import type { XyPane } from "./xy_pane";
import { TriggerBar } from "./trigger_bar";

interface ControlsProps {
  model: PlotModel;
  panes: Pane[];
  /** What draws them, and the x-y plot: for pictures. */
  made: Map<string, PlotPane>;
  xy: { current: XyPane | null };
}

export function Controls({ model, made, panes, xy }: ControlsProps) {
  const isPaused = model.isPaused.value;
  const [isTriggerShown, setTriggerShown] = useState(false);
  const savePicture = () =>
    savePng(
      model,
      panes.map((pane) => made.get(pane.key)).filter((pane) => pane !== undefined),
      xy.current?.canvas,
    );
  return (
    <>
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
        <button type="button" aria-label="Earlier" title="Earlier (Page up)" onClick={() => model.pan(-0.5)}>
          ◂
        </button>
        {isPaused && (
          <>
            <button type="button" aria-label="Later" title="Later (Page down)" onClick={() => model.pan(0.5)}>
              ▸
            </button>
            <button type="button" class="primary" title="Back to the present (Home)" onClick={() => model.toPresent()}>
              Live
            </button>
          </>
        )}
        <FieldChoice model={model} panes={panes} />
        <button
          type="button"
          aria-pressed={model.xy.value !== null}
          title="Draw a field over another"
          onClick={() => (model.xy.value = model.xy.peek() ? null : { x: "", y: "", isEqual: false })}
        >
          X-Y
        </button>
        <button type="button" aria-expanded={isTriggerShown} onClick={() => setTriggerShown(!isTriggerShown)}>
          Trigger
        </button>
        <span class="push row">
          {model.feed.lost.value > 0 && <span class="soft">{model.feed.lost.value} samples lost</span>}
          <button type="button" title="The rows that are shown" onClick={() => saveShown(model)}>
            CSV
          </button>
          <button
            type="button"
            title="Each control step of what is shown, from the recording of the run; of more than some seconds the smallest and the largest values"
            onClick={() => void saveAll(model)}
          >
            CSV, all steps
          </button>
          <button type="button" onClick={() => void savePicture()}>
            PNG
          </button>
        </span>
      </div>
      <TriggerBar model={model} isOpen={isTriggerShown} />
    </>
  );
}
