/** Gains of a servo, with what they do: the step response before and after a change. */

import { signal } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import uPlot from "uplot";
import { KeptForms } from "../../kept";
import { shown } from "../../model/numbers";
import { checkAll, type ParameterRow } from "../../model/parameters";
import { checkStep, LENGTH, STEP } from "../../model/step_form";
import { notifyError } from "../../parts/notices";
import { palette } from "../../parts/palette";
import type { DeviceRow } from "../../model/door";
import { may } from "../../store";
import { theme } from "../../theme";
import { useFieldValues } from "./fields";
import { recordStep, type StepResponse } from "./step_recording";
import { askVerb } from "./verbs";

interface Responses {
  before: StepResponse | null;
  after: StepResponse | null;
}

const USUAL_STEP: Record<string, string> = { step_deg: "10", length_s: "0.5" };
const forms = new KeptForms("bench.gains");
const steps = new KeptForms("bench.steps");
const recorded = signal<Record<string, Responses>>({});

export function hasGains(device: DeviceRow): boolean {
  return device.verbs["gains"] !== undefined && device.verbs["position"] !== undefined;
}

export function Gains({ device }: { device: DeviceRow }) {
  const rows = device.verbs["gains"]?.parameters ?? [];
  const values = useFieldValues(device, 1000);
  const typed = forms.of(device.name);
  const setTyped = (texts: Record<string, string>) => forms.put(device.name, texts);
  const step = { ...USUAL_STEP, ...steps.of(device.name) };
  const setStep = (texts: Record<string, string>) => steps.put(device.name, texts);
  const [busy, setBusy] = useState("");
  const { values: wanted, problems } = checkAll(rows, typed);
  const asked = checkStep(step);
  const isChanged = Object.keys(wanted).length > 0 && Object.keys(problems).length === 0;
  const record = () => recordStep(device, asked.step_deg, asked.length_s);
  const remember = (change: Partial<Responses>) => {
    const known = recorded.value[device.name] ?? { before: null, after: null };
    recorded.value = { ...recorded.value, [device.name]: { ...known, ...change } };
  };
  const carryOut = async (word: string, work: () => Promise<void>) => {
    setBusy(word);
    try {
      await work();
    } catch (error) {
      notifyError(error);
    } finally {
      setBusy("");
    }
  };
  const stepOnly = () =>
    carryOut("step", async () => {
      const before = recorded.value[device.name]?.after ?? null;
      remember({ before, after: await record() });
    });
  const apply = () =>
    carryOut("apply", async () => {
      await askVerb(device.name, "gains", wanted);
      setTyped({});
    });
  const compare = () =>
    carryOut("compare", async () => {
      remember({ before: await record(), after: null });
      await askVerb(device.name, "gains", wanted);
      setTyped({});
      remember({ after: await record() });
    });
  const isOff = !may("operator") || busy !== "" || Object.keys(asked.problems).length > 0;
  return (
    <div class="gains">
      <div class="gain-fields">
        {rows.map((row) => (
          <GainField
            key={row.name}
            row={row}
            value={values[row.name]}
            text={typed[row.name] ?? ""}
            problem={problems[row.name]}
            onChange={(text) => setTyped({ ...typed, [row.name]: text })}
          />
        ))}
      </div>
      <div class="row step-fields">
        {[STEP, LENGTH].map((row) => (
          <div key={row.name}>
            <label>
              {row.summary}{" "}
              <input
                class="mono is-number"
                inputMode="decimal"
                value={step[row.name]}
                aria-invalid={row.name in asked.problems}
                aria-describedby={row.name in asked.problems ? `step-${row.name}-problem` : undefined}
                onInput={(event) => setStep({ ...step, [row.name]: event.currentTarget.value })}
              />{" "}
              {row.unit}
            </label>
            <Problem id={`step-${row.name}-problem`} text={asked.problems[row.name]} />
          </div>
        ))}
      </div>
      <div class="row">
        <button type="button" class="primary" disabled={isOff} onClick={() => void stepOnly()}>
          {busy === "step" ? "Stepping …" : "Step response"}
        </button>
        <button type="button" disabled={!may("operator") || busy !== "" || !isChanged} onClick={() => void apply()}>
          Set gains
        </button>
        <button type="button" disabled={isOff || !isChanged} onClick={() => void compare()}>
          {busy === "compare" ? "Comparing …" : "Step, set gains, step again"}
        </button>
      </div>
      <ResponseView responses={recorded.value[device.name] ?? { before: null, after: null }} />
    </div>
  );
}

interface GainProps {
  row: ParameterRow;
  value: number | null | undefined;
  text: string;
  problem: string | undefined;
  onChange(text: string): void;
}

function GainField({ row, value, text, problem, onChange }: GainProps) {
  const id = `gain-${row.name}-problem`;
  return (
    <div>
      <label title={row.summary}>
        <span class="mono">{row.name}</span>
        <input
          class="mono is-number"
          inputMode="decimal"
          placeholder={value === null || value === undefined ? "" : String(Number(value.toPrecision(5)))}
          value={text}
          aria-invalid={problem !== undefined}
          aria-describedby={problem !== undefined ? id : undefined}
          aria-label={`${row.name}${row.unit ? ` in ${row.unit}` : ""}, now ${value ?? "not known"}`}
          onInput={(event) => onChange(event.currentTarget.value)}
        />
        <span class="soft">{row.unit}</span>
      </label>
      <Problem id={id} text={problem} />
    </div>
  );
}

/** Why a field is not taken, below it. */
function Problem({ id, text }: { id: string; text: string | undefined }) {
  return text === undefined ? null : (
    <span id={id} class="problem" role="alert">
      {text}
    </span>
  );
}

/** The two responses over one time axis, with their figures. */
function ResponseView({ responses }: { responses: Responses }) {
  const place = useRef<HTMLDivElement>(null);
  const { before, after } = responses;
  useEffect(() => {
    if (!place.current || (!before && !after)) return;
    const plot = drawResponses(place.current, before, after);
    const resize = new ResizeObserver(() => place.current && plot.setSize({ width: place.current.clientWidth, height: place.current.clientHeight }));
    resize.observe(place.current);
    return () => {
      resize.disconnect();
      plot.destroy();
    };
  }, [before, after, theme.value]);
  if (!before && !after) return <p class="soft">The step response is drawn here: one button makes it, and keeps the one before.</p>;
  return (
    <>
      <div class="response-plot" ref={place} role="img" aria-label="Step responses before and after; the table has their figures" />
      <div class="scroll-x" role="region" aria-label="Figures of the step responses" tabIndex={0}>
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
              <th scope="col" class="num" title="at the end">
                error
              </th>
            </tr>
          </thead>
          <tbody>
            <ResponseRow name="before" trace={2} response={before} />
            <ResponseRow name="after" trace={1} response={after} />
            {after && (
              <tr>
                <th scope="row" class="trace trace-set-point">
                  set-point
                </th>
                <td colSpan={4} class="soft">
                  dashed; positions are in deg from where the shaft was
                </td>
              </tr>
            )}
          </tbody>
        </table>
      </div>
    </>
  );
}

function ResponseRow({ name, trace, response }: { name: string; trace: number; response: StepResponse | null }) {
  if (!response) return null;
  const { rise_s, overshoot_percent, settling_s, finalError } = response.figures;
  return (
    <tr>
      <th scope="row" class={`trace trace-${trace}`}>
        {name}
      </th>
      <td class="num">{shown(rise_s * 1000, 1)} ms</td>
      <td class="num">{shown(overshoot_percent, 1)} %</td>
      <td class="num">{Number.isNaN(settling_s) ? "never" : `${shown(settling_s * 1000, 1)} ms`}</td>
      <td class="num">{shown(finalError, 3)} deg</td>
    </tr>
  );
}

function drawResponses(place: HTMLElement, before: StepResponse | null, after: StepResponse | null): uPlot {
  const colours = palette();
  const font = `11px ${colours.mono}`;
  const axis = { stroke: colours.soft, font, grid: { stroke: colours.grid, width: 1 }, ticks: { stroke: colours.line, width: 1, size: 4 } };
  const tables: uPlot.AlignedData[] = [];
  if (before) tables.push([before.times_s, before.position_deg]);
  if (after) tables.push([after.times_s, after.position_deg, after.setpoint_deg]);
  const series: uPlot.Series[] = [{}];
  const line = (label: string, stroke: string, dash?: number[]): uPlot.Series => ({
    label,
    stroke,
    width: 1.5,
    spanGaps: true,
    points: { show: false },
    ...(dash ? { dash } : {}),
  });
  if (before) series.push(line("before", colours.traces[1]!));
  if (after) series.push(line("after", colours.traces[0]!), line("set-point", colours.soft, [4, 4]));
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
