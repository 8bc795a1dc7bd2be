/** A run before it starts: its steps as a time line, and the planned set-points of its axes. */

import { useSignal } from "@preact/signals";
import { shown } from "../../model/numbers";
import { angleAt, laneOf, lineOfStep, pathOf, type RunPlan, rangeOf } from "../../model/run_plan";
import { goTo } from "../../parts/editor/text_editor";
import { draft, isGood, plan } from "./run_text";
import "./run_plan.css";

const WIDTH = 1000;
const HEIGHT = 200;
const LANES = 3;
/** A step that is shorter is drawn as long: it can be pressed. */
const LEAST_SHARE = 0.02;

export function PlanCard() {
  const made = plan.value;
  return (
    <section class="card run-plan" aria-label="Plan of the run">
      <div class="card-head">
        <h2>Plan</h2>
        {made && <span class="mono soft">{`${made.isExact ? "" : "about "}${shown(made.duration_s)} s`}</span>}
      </div>
      {made ? <Plan made={made} /> : <p class="soft">A run without problems is drawn here before it starts.</p>}
    </section>
  );
}

function Plan({ made }: { made: RunPlan }) {
  const at_s = useSignal<number | null>(null);
  const range = rangeOf(made.axes);
  const { duration_s } = made;
  const lanes = laneOf(made.steps, duration_s * LEAST_SHARE, LANES);
  const share = (s: number) => (duration_s > 0 ? (100 * s) / duration_s : 0);
  const point = (event: PointerEvent) => {
    const box = (event.currentTarget as Element).getBoundingClientRect();
    at_s.value = Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1) * duration_s;
  };
  return (
    <div class={isGood.value ? undefined : "is-old"}>
      <ol class="plan-steps" aria-label="Steps over time" data-lanes={Math.max(...lanes, 0) + 1}>
        {made.steps.map((step, at) => (
          <li
            key={at}
            style={{
              left: `${Math.min(share(step.from_s), 100 - 100 * LEAST_SHARE)}%`,
              width: `${Math.max(share(step.to_s - step.from_s), 100 * LEAST_SHARE)}%`,
            }}
            data-lane={lanes[at]}
          >
            <button
              type="button"
              title={`${step.number}: ${step.text}, from ${shown(step.from_s)} to ${shown(step.to_s)} s`}
              aria-label={`Step ${step.number}, ${step.text}, from ${shown(step.from_s)} to ${shown(step.to_s)} s: go to its line`}
              onClick={() => goTo("run", { line: lineOfStep(draft.peek().text, step.number), column: 1 })}
            >
              {step.number} {step.text}
            </button>
          </li>
        ))}
      </ol>
      <div class="plan-plot">
        <div class="plan-scale mono soft" aria-hidden="true">
          <span>{shown(range[1], 0)} deg</span>
          <span>{shown(range[0], 0)} deg</span>
        </div>
        <svg
          viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
          preserveAspectRatio="none"
          role="img"
          aria-label="Planned set-points over time"
          onPointerMove={point}
          onPointerLeave={() => (at_s.value = null)}
        >
          {range[0] < 0 && range[1] > 0 && <line class="plan-zero" x1={0} x2={WIDTH} y1={zero(range)} y2={zero(range)} />}
          {made.steps.map((step, at) => (
            <line key={at} class="plan-step" x1={(share(step.from_s) / 100) * WIDTH} x2={(share(step.from_s) / 100) * WIDTH} y1={0} y2={HEIGHT} />
          ))}
          {made.axes.map((axis, at) => (
            <path key={axis.name} class={`plan-line is-${(at % 6) + 1}`} d={pathOf(axis, duration_s, range, WIDTH, HEIGHT)} />
          ))}
          {at_s.value !== null && <line class="plan-at" x1={(share(at_s.value) / 100) * WIDTH} x2={(share(at_s.value) / 100) * WIDTH} y1={0} y2={HEIGHT} />}
        </svg>
        <div class="plan-times mono soft" aria-hidden="true">
          <span>0 s</span>
          <span>{shown(duration_s / 2)} s</span>
          <span>{shown(duration_s)} s</span>
        </div>
      </div>
      <ul class="plan-legend" aria-label="Axes of the plan">
        {made.axes.map((axis, at) => (
          <li key={axis.name}>
            <i class={`is-${(at % 6) + 1}`} /> {axis.name} <span class="mono">{said(axis, at_s.value)}</span>
          </li>
        ))}
        {at_s.value !== null && <li class="mono soft">at {shown(at_s.value)} s</li>}
      </ul>
      {!made.isExact && <p class="soft">Boards make ramps of their own here, or the run waits for something: its times are about.</p>}
      {made.stepsLeftOut > 0 && <p class="soft">{made.stepsLeftOut} further steps are not listed.</p>}
    </div>
  );
}

function zero([low, high]: [number, number]): number {
  return HEIGHT - (-low / (high - low)) * HEIGHT;
}

/** Angle at a time, else from where to where the axis goes. */
function said(axis: RunPlan["axes"][number], at_s: number | null): string {
  if (at_s !== null) return `${shown(angleAt(axis, at_s))} deg`;
  return `${shown(axis.position_deg[0], 0)} to ${shown(axis.position_deg.at(-1), 0)} deg`;
}
