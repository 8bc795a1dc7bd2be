/** A form for the parameters of a verb, a fault or anything else that a table describes. */

import { useId, useState } from "preact/hooks";
import { check, checkAll, formOf, isOptional, limitsOf, type ParameterRow } from "../model/parameters";

interface FormProps {
  rows: ParameterRow[];
  /** Text of the button. */
  action: string;
  /** Called with the values that were typed, checked; what was left out is not among them. */
  onSubmit(values: Record<string, unknown>): unknown;
  /** Values to begin with, by name. */
  given?: Readonly<Record<string, string>>;
  /** Called with the texts of all fields when one of them is typed at. */
  onType?(texts: Record<string, string>): void;
  isDisabled?: boolean;
  why?: string;
  isDanger?: boolean;
}

function initial(rows: ParameterRow[], given: Readonly<Record<string, string>>): Record<string, string> {
  const texts: Record<string, string> = {};
  for (const row of rows) {
    const isGiven = row.default !== null && row.default !== undefined;
    texts[row.name] = given[row.name] ?? (isGiven ? String(row.default) : formOf(row) === "choice" ? (row.choices?.[0] ?? "") : "");
  }
  return texts;
}

export function ParameterForm({ rows, action, onSubmit, given = {}, onType, isDisabled = false, why, isDanger }: FormProps) {
  const [typed, setTyped] = useState(() => initial(rows, given));
  const [problems, setProblems] = useState<Record<string, string>>({});
  const [isBusy, setBusy] = useState(false);
  const form = useId();
  const change = (row: ParameterRow, text: string) => {
    const texts = { ...typed, [row.name]: text };
    setTyped(texts);
    onType?.(texts);
    const checked = check(row, text);
    const { [row.name]: _, ...others } = problems;
    setProblems("problem" in checked && text !== "" ? { ...others, [row.name]: checked.problem } : others);
  };
  const submit = async (event: SubmitEvent) => {
    event.preventDefault();
    const checked = checkAll(rows, typed);
    setProblems(checked.problems);
    const first = Object.keys(checked.problems)[0];
    if (first !== undefined) {
      document.getElementById(`${form}-${first}`)?.focus();
      return;
    }
    setBusy(true);
    try {
      await onSubmit(checked.values);
    } finally {
      setBusy(false);
    }
  };
  return (
    <form class="parameters" noValidate onSubmit={(event) => void submit(event)}>
      {rows.map((row) => (
        <Field
          key={row.name}
          id={`${form}-${row.name}`}
          row={row}
          text={typed[row.name] ?? ""}
          problem={problems[row.name]}
          onChange={(text) => change(row, text)}
        />
      ))}
      <button type="submit" class={isDanger ? "danger" : "primary"} disabled={isDisabled || isBusy} title={why}>
        {action}
      </button>
    </form>
  );
}

interface FieldProps {
  id: string;
  row: ParameterRow;
  text: string;
  problem: string | undefined;
  onChange(text: string): void;
}

function Field({ id, row, text, problem, onChange }: FieldProps) {
  const limits = limitsOf(row);
  const hint = [row.summary, limits, isOptional(row) && !("default" in row && row.default != null) ? "may be left out" : ""].filter(Boolean).join("; ");
  return (
    <div class="parameter">
      <label htmlFor={id}>
        <span class="mono">{row.name}</span>
      </label>
      <Control id={id} row={row} text={text} isBad={problem !== undefined} onChange={onChange} />
      <span id={`${id}-hint`} class={problem ? "problem" : "soft"} role={problem ? "alert" : undefined}>
        {problem ?? hint}
      </span>
    </div>
  );
}

function Control({ id, row, text, isBad, onChange }: Omit<FieldProps, "problem"> & { isBad: boolean }) {
  const shared = { id, name: row.name, "aria-describedby": `${id}-hint`, "aria-invalid": isBad };
  const form = formOf(row);
  if (form === "choice") {
    return (
      <select {...shared} value={text} onChange={(event) => onChange(event.currentTarget.value)}>
        {isOptional(row) && row.default == null && <option value="">(left out)</option>}
        {row.choices?.map((choice) => (
          <option key={choice} value={choice}>
            {choice}
          </option>
        ))}
      </select>
    );
  }
  if (form === "flag") {
    return <input {...shared} type="checkbox" checked={text === "true"} onChange={(event) => onChange(String(event.currentTarget.checked))} />;
  }
  const isNumber = form === "number" || form === "whole";
  return (
    <span class="with-unit">
      <input
        {...shared}
        class={isNumber ? "is-number mono" : ""}
        inputMode={isNumber ? "decimal" : "text"}
        autocomplete="off"
        spellcheck={false}
        value={text}
        onInput={(event) => onChange(event.currentTarget.value)}
      />
      {row.unit && <span class="soft"> {row.unit}</span>}
    </span>
  );
}
