/** Runs that the bench remembers, with their progress. */

import { shown } from "../../model/numbers";
import { type AxisReport, readRun, type RunProgress } from "../../model/run_progress";
import { notifyError } from "../../parts/notices";
import { whenLoaded } from "../../parts/when_loaded";
import { link, may, runs, status, takeProgress } from "../../store";

const RunError = whenLoaded(async () => (await import("./run_error")).RunError);

export function RunList() {
  return (
    <section class="card" aria-label="Runs of this bench">
      <div class="card-head">
        <h2>Progress</h2>
      </div>
      {runs.value.length === 0 && <p class="soft">No run yet.</p>}
      {runs.value.map((run) => (
        <RunCard key={run.run} run={run} />
      ))}
    </section>
  );
}

function RunCard({ run }: { run: RunProgress }) {
  const { step, steps, planned_end_ns: end_ns } = run;
  const isUnderWay = run.state === "running" || run.state === "queued";
  const left_s = end_ns !== null ? Math.max(0, (end_ns - (status.value.sim_ns ?? 0)) / 1e9) : null;
  const cancel = async (how: "grace" | "prejudice") => {
    try {
      const told = readRun(await link.ask("cancel_run", run.run, { how }));
      if (told) takeProgress(told);
    } catch (error) {
      notifyError(error);
    }
  };
  return (
    <article class="run" aria-label={`Run ${run.run}`}>
      <div class="row">
        <strong class="run-name">{run.run}</strong>
        <span class={`pill is-${run.state}`}>{run.state}</span>
        <span class="soft mono">
          step {step} of {steps}
          {isUnderWay && left_s !== null && `, ${left_s.toFixed(1)} s left`}
        </span>
        {isUnderWay && (
          <span class="push row">
            <button type="button" disabled={!may("operator")} title="with a ramp" onClick={() => void cancel("grace")}>
              Cancel
            </button>
            <button type="button" class="danger" disabled={!may("operator")} title="without a ramp" onClick={() => void cancel("prejudice")}>
              Stop at once
            </button>
          </span>
        )}
      </div>
      <progress aria-label={`Progress of ${run.run}`} max={Math.max(steps, 1)} value={run.state === "done" ? Math.max(steps, 1) : step} />
      {run.why && <p class="problem">{run.why}</p>}
      <Axes run={run.run} axes={run.axes} />
      {!isUnderWay && <RunError run={run} />}
    </article>
  );
}

function Axes({ run, axes }: { run: string; axes: Record<string, AxisReport> }) {
  const rows = Object.entries(axes);
  if (!rows.length) return null;
  return (
    <div class="scroll-x" tabIndex={0} role="region" aria-label={`Axes of the run ${run}`}>
      <table>
        <thead>
          <tr>
            <th scope="col">axis</th>
            <th scope="col" class="num">
              is at
            </th>
            <th scope="col" class="num">
              target
            </th>
            <th scope="col" class="num">
              error, most
            </th>
            <th scope="col" class="num">
              rms
            </th>
            <th scope="col">at the end</th>
          </tr>
        </thead>
        <tbody>
          {rows.map(([name, axis]) => (
            <tr key={name}>
              <th scope="row">{name}</th>
              <td class="num">{shown(axis.position_deg)} deg</td>
              <td class="num">{shown(axis.target_deg)} deg</td>
              <td class="num">{shown(axis.error_max_deg, 3)}</td>
              <td class="num">{shown(axis.error_rms_deg, 3)}</td>
              <td>{axis.at_end ?? ""}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
