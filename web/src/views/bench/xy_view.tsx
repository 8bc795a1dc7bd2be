/** A field over another: what is drawn, and its choice. */

import { useEffect, useRef } from "preact/hooks";
import { shown } from "../../model/numbers";
import { samplingText } from "../../model/sampling";
import { devices } from "../../store";
import { theme } from "../../theme";
import { write } from "../../parts/write";
import { besideOf, fieldAt } from "./axis_fields";
import type { PlotModel, XyChoice } from "./plot_model";
import { type XyAxis, XyPane } from "./xy_pane";

const TELL_EVERY_MS = 250;

export function XyView({ model, choice, made }: { model: PlotModel; choice: XyChoice; made: { current: XyPane | null } }) {
  const { signals } = model;
  const x = signals.includes(choice.x) ? choice.x : signals[0];
  const y = signals.includes(choice.y) ? choice.y : signals.find((each) => each !== x);
  if (x === undefined || y === undefined) return <p class="empty">Choose two fields: one is drawn over the other.</p>;
  const put = (change: Partial<XyChoice>) => (model.xy.value = { x, y, isEqual: choice.isEqual, ...change });
  const select = (label: string, value: string, key: "x" | "y") => (
    <select aria-label={label} value={value} onChange={(event) => put({ [key]: event.currentTarget.value })}>
      {signals.map((name) => (
        <option key={name} value={name}>
          {name}
        </option>
      ))}
    </select>
  );
  return (
    <div class="xy">
      <div class="row">
        {select("Field upwards", y, "y")}
        <span class="soft">over</span>
        {select("Field to the right", x, "x")}
        <label>
          <input type="checkbox" checked={choice.isEqual} onChange={() => put({ isEqual: !choice.isEqual })} /> equal scales
        </label>
        <button type="button" aria-label="Turn the x-y plot's axes" title="Turn the axes" onClick={() => put({ x: y, y: x })}>
          ⇄
        </button>
      </div>
      <Picture key={`${x} ${y} ${choice.isEqual} ${theme.value}`} model={model} x={x} y={y} isEqual={choice.isEqual} made={made} />
    </div>
  );
}

function axisOf(model: PlotModel, address: string): XyAxis {
  const own = besideOf(address)?.axis === model.axis ? besideOf(address)!.field : address;
  return { name: own, label: address, unit: fieldAt(devices.peek(), address)?.field.unit ?? "" };
}

interface PictureProps {
  model: PlotModel;
  x: string;
  y: string;
  isEqual: boolean;
  made: { current: XyPane | null };
}

function Picture({ model, x, y, isEqual, made }: PictureProps) {
  const place = useRef<HTMLCanvasElement>(null);
  const told = useRef<HTMLParagraphElement>(null);
  useEffect(() => {
    if (!place.current) return;
    const pane = new XyPane(place.current, model, axisOf(model, x), axisOf(model, y), isEqual);
    made.current = pane;
    const timer = window.setInterval(() => {
      const { sampling } = model.shownLayer(performance.now());
      const how = sampling.isExtremes ? `middle of ${samplingText(sampling)}` : samplingText(sampling);
      const text = Number.isNaN(pane.cut_s) ? how : `${how}; from ${shown(pane.cut_s, 2)} s on`;
      write(told.current, text);
    }, TELL_EVERY_MS);
    return () => {
      window.clearInterval(timer);
      if (made.current === pane) made.current = null;
      pane.end();
    };
  }, []);
  return (
    <>
      <canvas
        ref={place}
        class="xy-plot"
        role="img"
        aria-label={`${y} over ${x}`}
        onClick={(event) => {
          const at_s = made.current?.timeAt(event.offsetX, event.offsetY) ?? NaN;
          if (!Number.isNaN(at_s)) model.setCursor(event.shiftKey, at_s);
        }}
      />
      <p class="soft mono" ref={told} />
    </>
  );
}
