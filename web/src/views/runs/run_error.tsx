/** Following error of a run that is over, from the bench's recording. */

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { shown } from "../../model/numbers";
import { readRows } from "../../model/past";
import type { PlannedAxis } from "../../model/run_plan";
import type { RunProgress } from "../../model/run_progress";
import { askPast, trouble } from "../../past";
import { devices } from "../../store";
import { TimePlot } from "./time_plot";

const POINTS = 800;
/** Fields that are the distance of a shaft from its set-point, in degrees. */
const ERRORS = ["e", "following_error_deg"];
/** A recording is written once a second: its end is asked for so often. */
const TURNS = 5;
const TURN_MS = 1000;
const END_s = 0.1;

export function RunError({ run }: { run: RunProgress }) {
  const isOpen = useSignal(false);
  if (run.started_at_ns === null || run.ended_at_ns === null || !fieldsOf(run).length) return null;
  return (
    <details onToggle={(event) => (isOpen.value = event.currentTarget.open)}>
      <summary>Following error</summary>
      {isOpen.value && <Picture run={run} />}
    </details>
  );
}

function Picture({ run }: { run: RunProgress }) {
  const lines = useSignal<PlannedAxis[] | null>(null);
  const [from_s, to_s] = [(run.started_at_ns ?? 0) / 1e9, (run.ended_at_ns ?? 0) / 1e9];
  useEffect(() => {
    let isGone = false;
    const read = async () => {
      for (let turn = 0; turn < TURNS && !isGone; turn++) {
        const found = await errors(run, from_s, to_s);
        if (!isGone) lines.value = found;
        if (found.length && found.every(({ at_s }) => (at_s.at(-1) ?? 0) >= to_s - from_s - END_s)) return;
        await new Promise((resolve) => setTimeout(resolve, TURN_MS));
      }
    };
    void read();
    return () => void (isGone = true);
  }, [run.run, run.digest, run.started_at_ns]);
  if (lines.value === null) return <p class="soft">The recording is read …</p>;
  if (!lines.value.length) return <p class="soft">The recording has nothing of it{trouble.value && `: ${trouble.value}`}.</p>;
  return <TimePlot name={`Following error of ${run.run}`} lines={lines.value} duration_s={to_s - from_s} digits={2} about={most} />;
}

function fieldsOf(run: RunProgress): string[] {
  return Object.keys(run.axes).flatMap((axis) => {
    const field = devices.value.get(axis)?.fields.find(({ name, unit }) => ERRORS.includes(name) && unit === "deg");
    return field ? [`${axis}.${field.name}`] : [];
  });
}

async function errors(run: RunProgress, from_s: number, to_s: number): Promise<PlannedAxis[]> {
  const told = await askPast("past_samples", { fields: fieldsOf(run), from_s, to_s, points: POINTS, lane: `run ${run.run}` });
  return (told?.series ?? []).map(({ axis, rows, data, fields }) => {
    const values = readRows(data);
    const columns = fields.length + 1;
    const each = Array.from({ length: rows }, (_, row) => row * columns);
    return { name: axis, at_s: each.map((at) => values[at]! - from_s), position_deg: each.map((at) => values[at + 1]!) };
  });
}

function most({ position_deg }: PlannedAxis): string {
  return `at most ${shown(Math.max(...position_deg.map(Math.abs)), 3)} deg`;
}
