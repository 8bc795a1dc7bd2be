/** One pane of plots: its legend with values, and its plot. */

import { useEffect, useRef } from "preact/hooks";
import { digitsOf, shown } from "../../model/numbers";
import { samplingText } from "../../model/sampling";
import { write } from "../../parts/write";
import type { Pane } from "./axis_fields";
import { PlotPane } from "./plot_pane";
import type { PlotModel } from "./plot_model";
import { ValueRange } from "./value_range";

/** Values change with the lines, in the same frames, but less often: they are read. */
const VALUES_EVERY_MS = 200;
const NEARLY_MS = 150;

interface PaneProps {
  pane: Pane;
  model: PlotModel;
  isFirst: boolean;
  hasTimes: boolean;
  /** Whether any pane has a right axis. */
  isNarrow: boolean;
  made: Map<string, PlotPane>;
}

export function PaneView({ pane, model, isFirst, hasTimes, isNarrow, made }: PaneProps) {
  const place = useRef<HTMLDivElement>(null);
  const values = useRef<(HTMLElement | null)[]>([]);
  const sampling = useRef<HTMLElement>(null);
  useEffect(() => {
    if (!place.current) return;
    const drawn = new PlotPane(place.current, pane, model, isFirst, hasTimes, isNarrow);
    made.set(pane.key, drawn);
    const endClicks = cursorsByClicks(drawn, model);
    let told_ms = -Infinity;
    const tell = () => {
      const now_ms = performance.now();
      if (now_ms - told_ms < NEARLY_MS) return;
      told_ms = now_ms;
      tellValues(drawn, pane, model, values.current);
      write(sampling.current, samplingText(model.shownLayer(now_ms).sampling));
    };
    tell();
    drawn.onDrawn = tell;
    const timer = window.setInterval(tell, VALUES_EVERY_MS);
    return () => {
      window.clearInterval(timer);
      endClicks();
      if (made.get(pane.key) === drawn) made.delete(pane.key);
      drawn.end();
    };
  }, [isFirst, hasTimes, isNarrow]);
  return (
    <div class={hasTimes ? "pane has-times" : "pane"}>
      <div class="pane-legend">
        <span class="soft">
          {pane.title}
          {pane.unit && ` (${pane.unit})`}
        </span>
        {pane.fields.map((field, at) => (
          <span key={field.name} class={`trace trace-${(at % 6) + 1}`} title={field.meaning}>
            {model.labelOf(field.name)} {field.isRight && <span class="soft">right{field.unit && ` (${field.unit})`} </span>}
            <span class="mono trace-value" ref={(element) => void (values.current[at] = element)} />
          </span>
        ))}
        <span class="push row pane-range">
          {isFirst && <span class="soft mono" ref={sampling} title="How the samples that are drawn were made" />}
          <ValueRange pane={pane} model={model} made={made} />
          {pane.rightUnit !== undefined && <ValueRange pane={pane} model={model} made={made} isRight />}
        </span>
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
  const at_s = drawn.hovered_s() ?? (model.paused.peek() ? model.to_s.peek() : model.layers[0]!.ring.last_s);
  pane.fields.forEach((field, at) => {
    const text = shown(model.valueAt(field.name, at_s, field.unit), digitsOf(field.unit));
    write(places[at], text);
  });
}
