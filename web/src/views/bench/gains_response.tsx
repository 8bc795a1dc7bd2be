/** Two step responses over one time axis, with their figures, what they differ by, and as files. */

import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { shown } from "../../model/numbers";
import { differenceOf, responsesCsv } from "../../model/step_table";
import { saveFile } from "../../parts/files";
import { notify } from "../../parts/notices";
import { palette } from "../../parts/palette";
import { theme } from "../../theme";
import { download, fileName } from "./export";
import type { StepResponse } from "./step_recording";

export interface Responses {
  before: StepResponse | null;
  after: StepResponse | null;
  /** Whether `before` stays when there is another step. */
  isHeld: boolean;
}

export const NO_RESPONSES: Responses = { before: null, after: null, isHeld: false };
const ROWS = [
  { name: "before", trace: 2 },
  { name: "after", trace: 1 },
] as const;
const TITLE_PX = 20;

interface Props {
  device: string;
  responses: Responses;
  hold(isHeld: boolean): void;
}

export function ResponseView({ device, responses, hold }: Props) {
  const place = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const { before, after, isHeld } = responses;
  const last = after ?? before;
  useEffect(() => {
    if (!place.current || (!before && !after)) return;
    const box = place.current;
    const made = drawn(box, responses);
    plot.current = made;
    const resize = new ResizeObserver(() => made.setSize({ width: box.clientWidth, height: box.clientHeight }));
    resize.observe(box);
    return () => {
      resize.disconnect();
      made.destroy();
      plot.current = null;
    };
  }, [before, after, theme.value]);
  if (!last) return <p class="soft">The step response is drawn here: one button makes it, and keeps the one before. The shaft goes back after each.</p>;
  return (
    <>
      <div class="pane-legend response-legend">
        <span class="soft">Position and set-point from where the shaft was (deg)</span>
        {ROWS.map(
          ({ name, trace }) =>
            responses[name] && (
              <span key={name} class={`trace trace-${trace}`}>
                {name}
              </span>
            ),
        )}
        <span class="trace trace-set-point">set-point</span>
        <span class="push soft mono" title="Samples in a second of simulated time">
          {last.rate_Hz}/s
        </span>
      </div>
      <div class="response-plot" ref={place} role="img" aria-label="Step responses before and after; the table has their figures" />
      <div class="scroll-x" role="region" aria-label="Figures of the step responses" tabIndex={0}>
        <FigureTable responses={responses} />
      </div>
      <div class="row">
        <button type="button" aria-pressed={isHeld} disabled={!before} title="Compare all further steps with this one" onClick={() => hold(!isHeld)}>
          Keep “before”
        </button>
        <span class="push row">
          <button type="button" onClick={() => saveFile(fileName(`${device}-step`, "csv"), new TextEncoder().encode(responsesCsv(responses)), "text/csv")}>
            CSV
          </button>
          <button type="button" onClick={() => void savePicture(device, responses, plot.current)}>
            PNG
          </button>
        </span>
      </div>
    </>
  );
}

function FigureTable({ responses }: { responses: Responses }) {
  const { before, after } = responses;
  const by = before && after ? differenceOf(before, after) : null;
  return (
    <table>
      <thead>
        <tr>
          <th scope="col">response</th>
          <th scope="col" class="num" title="from 10 to 90 %">
            rise
          </th>
          <th scope="col" class="num">
            overshoot
          </th>
          <th scope="col" class="num" title="within 2 % for good">
            settled
          </th>
          <th scope="col" class="num" title="mean of the last tenth, less the set-point">
            error
          </th>
        </tr>
      </thead>
      <tbody>
        {ROWS.map(({ name, trace }) => {
          const response = responses[name];
          return response && <FigureRow key={name} name={name} classes={`trace trace-${trace}`} figures={textsOf(response.figures)} />;
        })}
        {by && (
          <FigureRow
            name="after − before"
            classes=""
            figures={[signed(by.rise_ms, 2), signed(by.overshoot, 1), signed(by.settling_ms, 2), signed(by.error_deg, 3)]}
          />
        )}
        {by && by.gains.length > 0 && (
          <tr>
            <th scope="row">gains</th>
            <td colSpan={4} class="mono">
              {by.gains.map(({ name, was, is }) => `${name} ${was} → ${is}`).join(", ")}
            </td>
          </tr>
        )}
      </tbody>
    </table>
  );
}

function FigureRow({ name, classes, figures }: { name: string; classes: string; figures: string[] }) {
  const units = ["ms", "%", "ms", "deg"];
  return (
    <tr>
      <th scope="row" class={classes}>
        {name}
      </th>
      {figures.map((text, at) => (
        <td key={at} class="num">
          {text === "never" || text === "–" ? text : `${text} ${units[at]}`}
        </td>
      ))}
    </tr>
  );
}

function textsOf({ rise_s, overshoot_percent, settling_s, final_error }: StepResponse["figures"]): string[] {
  const time = (value_s: number) => (Number.isNaN(value_s) ? "never" : shown(value_s * 1000, 2));
  return [time(rise_s), shown(overshoot_percent, 1), time(settling_s), signed(final_error, 3)];
}

function signed(value: number, digits: number): string {
  const text = shown(value, digits);
  return value > 0 && Number(value.toFixed(digits)) !== 0 ? `+${text}` : text;
}

function drawn(place: HTMLElement, { before, after }: Responses): uPlot {
  const colours = palette();
  const font = `11px ${colours.mono}`;
  const axis = { stroke: colours.soft, font, grid: { stroke: colours.grid, width: 1 }, ticks: { stroke: colours.line, width: 1, size: 4 } };
  const series: uPlot.Series[] = [{}];
  const tables: uPlot.AlignedData[] = [];
  const last = after ?? before;
  const line = (label: string, stroke: string, dash?: number[]): uPlot.Series => ({
    label,
    stroke,
    width: 1.5,
    spanGaps: true,
    points: { show: false },
    ...(dash ? { dash } : {}),
  });
  for (const { name, trace } of ROWS) {
    const rows = { before, after }[name]?.rows;
    if (!rows) continue;
    tables.push([rows.times_s, rows.position, ...({ before, after }[name] === last ? [rows.setpoint] : [])] as uPlot.AlignedData);
    series.push(line(name, colours.traces[trace - 1]!));
  }
  series.push(line("set-point", colours.soft, [4, 4]));
  return new uPlot(
    {
      width: place.clientWidth,
      height: place.clientHeight,
      legend: { show: false },
      scales: { x: { time: false } },
      axes: [
        { ...axis, size: 28, values: (_plot, splits) => splits.map((value) => `${+(value * 1000).toFixed(3)} ms`) },
        { ...axis, size: 52, label: "deg", labelSize: 16, labelFont: font, values: (_plot, splits) => splits.map((value) => `${+value.toFixed(3)}`) },
      ],
      series,
      cursor: { drag: { x: true, y: false } },
    },
    uPlot.join(tables),
    place,
  );
}

/** Save the plot with a title that has the figures. */
async function savePicture(device: string, responses: Responses, plot: uPlot | null): Promise<void> {
  const of = plot?.ctx.canvas;
  const scale = devicePixelRatio;
  const shownRows = ROWS.flatMap(({ name, trace }) => (responses[name] ? [{ name, trace, response: responses[name] }] : []));
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d");
  if (!of || !context) return notify("there is no plot to save", true);
  const head = (shownRows.length + 1) * TITLE_PX * scale;
  canvas.width = of.width;
  canvas.height = of.height + head;
  const colours = palette();
  context.fillStyle = colours.panel;
  context.fillRect(0, 0, canvas.width, canvas.height);
  const write = (text: string, row: number, colour: string) => {
    context.fillStyle = colour;
    context.fillText(text, 8 * scale, (row + 0.8) * TITLE_PX * scale);
  };
  context.font = `bold ${12 * scale}px ${colours.mono}`;
  write(`${device}: step response, deg from where the shaft was; dashed: set-point`, 0, colours.ink);
  context.font = `${11 * scale}px ${colours.mono}`;
  shownRows.forEach(({ name, trace, response }, at) => {
    const [rise, overshoot, settled, error] = textsOf(response.figures);
    write(`${name}: rise ${rise} ms, overshoot ${overshoot} %, settled ${settled} ms, error ${error} deg`, at + 1, colours.traces[trace - 1]!);
  });
  context.drawImage(of, 0, head);
  const png = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve, "image/png"));
  if (png) download(fileName(`${device}-step`, "png"), png);
}
