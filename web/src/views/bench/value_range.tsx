/** Range of values of a pane. */

import { type Pane, rangeKey } from "./axis_fields";
import type { PlotModel } from "./plot_model";
import type { PlotPane } from "./plot_pane";

interface ValueRangeProps {
  pane: Pane;
  model: PlotModel;
  made: Map<string, PlotPane>;
  isRight?: boolean;
}

/** Whether the range of values of a pane's axis fits what is shown, or stays as it is written. */
export function ValueRange({ pane, model, made, isRight = false }: ValueRangeProps) {
  const key = rangeKey(pane, isRight);
  const fixed = model.fixed.value.get(key);
  const unit = isRight ? pane.rightUnit : pane.unit;
  const what = `${isRight ? "right axis of " : ""}${pane.title.toLowerCase()}`;
  const toggle = () => {
    const [low = 0, high = 1] = made.get(pane.key)?.rangeOf(isRight) ?? [];
    model.fix(key, fixed ? null : [low, high]);
  };
  const end = (at: 0 | 1, name: string) => {
    if (!fixed) return null;
    const take = (event: Event & { currentTarget: HTMLInputElement }) => {
      const value = Number(event.currentTarget.value);
      const range: [number, number] = at ? [fixed[0], value] : [value, fixed[1]];
      const isWrong = !event.currentTarget.value.trim() || !(range[0] < range[1]) || !Number.isFinite(value);
      event.currentTarget.setAttribute("aria-invalid", String(isWrong));
      event.currentTarget.title = isWrong ? `write a number; the lower end is below the upper one, ${fixed[0]} to ${fixed[1]} now` : "";
      if (!isWrong) model.fix(key, range);
    };
    return (
      <input
        class="mono is-number"
        inputMode="decimal"
        aria-label={`${name} end of the ${what} shown`}
        defaultValue={String(Number(fixed[at].toPrecision(6)))}
        onInput={take}
      />
    );
  };
  const text = `${isRight ? "right" : "y"} ${fixed ? "fixed" : "free"}`;
  return (
    <>
      {end(0, "Lower")}
      {end(1, "Upper")}
      <button
        type="button"
        aria-pressed={fixed !== undefined}
        aria-label={`${text}: fixed range of ${what}`}
        title={`Keep the range${unit ? ` in ${unit}` : ""} as it is`}
        onClick={toggle}
      >
        {text}
      </button>
    </>
  );
}
