/** Angles of axes over the time of a run, as a picture; pointing at it reads them. */

import { useSignal } from "@preact/signals";
import { shown } from "../../model/numbers";
import { angleAt, type PlannedAxis, pathOf, rangeOf } from "../../model/run_plan";

const WIDTH = 1000;
const HEIGHT = 200;
const COLOURS = 6;

interface Props {
  name: string;
  lines: readonly PlannedAxis[];
  duration_s: number;
  /** Times that have a mark. */
  marks_s?: readonly number[];
  digits: number;
  /** What is told of a line while nothing is pointed at; left out: from where to where it goes. */
  about?(line: PlannedAxis): string;
}

export function TimePlot({ name, lines, duration_s, marks_s = [], digits, about = goes }: Props) {
  const at_s = useSignal<number | null>(null);
  const range = rangeOf(lines);
  const across = (s: number) => (duration_s > 0 ? (s / duration_s) * WIDTH : 0);
  const zero = HEIGHT + (range[0] / (range[1] - range[0])) * HEIGHT;
  const point = (event: PointerEvent) => {
    const box = (event.currentTarget as Element).getBoundingClientRect();
    at_s.value = Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1) * duration_s;
  };
  return (
    <>
      <div class="plan-plot">
        <div class="plan-scale mono soft" aria-hidden="true">
          <span>{shown(range[1], digits)} deg</span>
          <span>{shown(range[0], digits)} deg</span>
        </div>
        <svg
          viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
          preserveAspectRatio="none"
          role="img"
          aria-label={name}
          onPointerMove={point}
          onPointerLeave={() => (at_s.value = null)}
        >
          {range[0] < 0 && range[1] > 0 && <line class="plan-zero" x1={0} x2={WIDTH} y1={zero} y2={zero} />}
          {marks_s.map((mark_s, at) => (
            <line key={at} class="plan-step" x1={across(mark_s)} x2={across(mark_s)} y1={0} y2={HEIGHT} />
          ))}
          {lines.map((line, at) => (
            <path key={line.name} class={`plan-line is-${(at % COLOURS) + 1}`} d={pathOf(line, duration_s, range, WIDTH, HEIGHT)} />
          ))}
          {at_s.value !== null && <line class="plan-at" x1={across(at_s.value)} x2={across(at_s.value)} y1={0} y2={HEIGHT} />}
        </svg>
        <div class="plan-times mono soft" aria-hidden="true">
          <span>0 s</span>
          <span>{shown(duration_s / 2)} s</span>
          <span>{shown(duration_s)} s</span>
        </div>
      </div>
      <ul class="plan-legend" aria-label={`Axes: ${name}`}>
        {lines.map((line, at) => (
          <li key={line.name}>
            <i class={`is-${(at % COLOURS) + 1}`} /> {line.name}{" "}
            <span class="mono">{at_s.value === null ? about(line) : `${shown(angleAt(line, at_s.value), digits + 2)} deg`}</span>
          </li>
        ))}
        {at_s.value !== null && <li class="mono soft">at {shown(at_s.value)} s</li>}
      </ul>
    </>
  );
}

function goes({ position_deg }: PlannedAxis): string {
  return `${shown(position_deg[0], 0)} to ${shown(position_deg.at(-1), 0)} deg`;
}
