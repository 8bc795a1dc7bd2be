/** Values at the cursors, their differences, and figures of what is between them. */

import { between } from "../../model/between";
import { digitsOf, shown } from "../../model/numbers";
import type { PlotModel } from "./plot_model";

const FIGURES = ["B − A", "slope /s", "mean", "min", "max", "rms"];

/** One field at the cursors: the numbers of its row. */
function figuresOf(model: PlotModel, name: string, usual: string, a: number | null, b: number | null) {
  const value = (at: number | null) => (at === null ? NaN : model.valueAtCursor(name, at));
  const units = [a, b].filter((at) => at !== null).map((at) => model.unitAt(name, at, usual));
  const isOne = new Set(units).size === 1;
  const digits = digitsOf(units[0] ?? usual);
  const unit = [...new Set(units)].join(", ");
  if (a === null || b === null || !isOne) return { unit, digits, values: [value(a), value(b), ...FIGURES.map(() => NaN)] };
  const { layer, column } = model.placeOf(name, Math.min(a, b));
  const { slope, mean, least, most, rms } = between(layer.ring, column, a, b);
  return { unit, digits, values: [value(a), value(b), value(b) - value(a), slope, mean, least, most, rms] };
}

export function CursorsTable({ model }: { model: PlotModel }) {
  const a = model.cursorA.value;
  const b = model.cursorB.value;
  if ((a === null && b === null) || !model.isPaused.value) {
    return <p class="soft hint">Click: cursor A. Shift and click: cursor B. Drag: zoom. Double click: live.</p>;
  }
  const fields = [...model.device.fields.filter((field) => model.chosen.value.includes(field.name)), ...model.otherFields()];
  return (
    <div class="scroll-x" role="region" aria-label="Values at the cursors" tabIndex={0}>
      <table class="cursors">
        <thead>
          <tr>
            <th scope="col">field</th>
            {["A", "B", ...FIGURES].map((title) => (
              <th key={title} scope="col" class="num">
                {title}
              </th>
            ))}
            <th scope="col">unit</th>
          </tr>
        </thead>
        <tbody>
          <tr>
            <th scope="row">time</th>
            <td class="num">{shown(a, 4)}</td>
            <td class="num">{shown(b, 4)}</td>
            <td class="num">{a !== null && b !== null ? shown(b - a, 4) : "–"}</td>
            {FIGURES.slice(1).map((title) => (
              <td key={title} />
            ))}
            <td>s</td>
          </tr>
          {fields.map((field) => {
            const { unit, digits, values } = figuresOf(model, field.name, field.unit, a, b);
            return (
              <tr key={field.name}>
                <th scope="row">{model.labelOf(field.name)}</th>
                {values.map((value, at) => (
                  <td key={at} class="num">
                    {shown(value, digits)}
                  </td>
                ))}
                <td>{unit}</td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </div>
  );
}
