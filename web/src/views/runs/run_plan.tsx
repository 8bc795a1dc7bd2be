/** A run before it starts: its steps as a time line, and the planned set-points of its axes. */

import { shown } from "../../model/numbers";
import { laneOf, lineOfStep, type RunPlan } from "../../model/run_plan";
import { goTo } from "../../parts/editor/text_editor";
import { draft, isGood, plan } from "./run_text";
import { TimePlot } from "./time_plot";
import "./run_plan.css";

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
  const { duration_s } = made;
  const lanes = laneOf(made.steps, duration_s * LEAST_SHARE, LANES);
  const share = (s: number) => (duration_s > 0 ? (100 * s) / duration_s : 0);
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
      <TimePlot name="Planned set-points over time" lines={made.axes} duration_s={duration_s} marks_s={made.steps.map(({ from_s }) => from_s)} digits={0} />
      {!made.isExact && <p class="soft">Boards make ramps of their own here, or the run waits for something: its times are about.</p>}
      {made.stepsLeftOut > 0 && <p class="soft">{made.stepsLeftOut} further steps are not listed.</p>}
    </div>
  );
}
