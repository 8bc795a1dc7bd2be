/** Gains of a servo, with what they do: the step response before and after a change. */

import { signal } from "@preact/signals";
import { useRef, useState } from "preact/hooks";
import { KeptForms } from "../../kept";
import { checkAll, type ParameterRow } from "../../model/parameters";
import { checkStep, LENGTH, STEP } from "../../model/step_form";
import { notifyError } from "../../parts/notices";
import type { DeviceRow } from "../../model/door";
import { may } from "../../store";
import { useFieldValues } from "./fields";
import { NO_RESPONSES, type Responses, ResponseView } from "./gains_response";
import { recordStep } from "./step_recording";
import { askVerb } from "./verbs";

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
  const stop = useRef(new AbortController());
  const known = () => recorded.peek()[device.name] ?? NO_RESPONSES;
  const record = () => recordStep(device, asked.step_deg, asked.length_s, stop.current.signal);
  const remember = (change: Partial<Responses>) => (recorded.value = { ...recorded.peek(), [device.name]: { ...known(), ...change } });
  const carryOut = async (word: string, work: () => Promise<void>) => {
    setBusy(word);
    stop.current = new AbortController();
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
      const after = await record();
      const { isHeld, before, after: last } = known();
      remember({ before: isHeld ? before : last, after });
    });
  const apply = () =>
    carryOut("apply", async () => {
      await askVerb(device.name, "gains", wanted);
      setTyped({});
    });
  const compare = () =>
    carryOut("compare", async () => {
      const before = await record();
      remember(known().isHeld ? { after: before } : { before, after: null });
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
        {(busy === "step" || busy === "compare") && (
          <button type="button" class="stop" title="Record no more, and go back" onClick={() => stop.current.abort()}>
            Stop the step
          </button>
        )}
      </div>
      {Object.keys(problems).length > 0 && <p class="soft">Gains are set when all that is typed is right; a step needs only its own fields.</p>}
      <ResponseView device={device.name} responses={recorded.value[device.name] ?? NO_RESPONSES} hold={(isHeld) => remember({ isHeld })} />
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
