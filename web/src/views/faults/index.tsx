/** Faults: what is active, and the table of kinds as forms. */

import { KeptForms, keptText } from "../../kept";
import type { ParameterRow } from "../../model/parameters";
import { useId } from "preact/hooks";
import { notify, notifyError } from "../../parts/notices";
import { ParameterForm } from "../../parts/parameter_form";
import type { FaultKindRow } from "../../model/door";
import { activeFaults, benchTime_s, faultMarks, hello, link, may } from "../../store";
import type { ViewEntry } from "../view";
import { placesOf } from "./places";
import "./faults.css";

const forms = new KeptForms("faults.forms");
const chosenKind = keptText("faults.kind");
const chosenPlace = keptText("faults.place");
/** Kinds that happen once are never listed as active: their marks are made here, and last a moment. */
let onceNumber = -1;

function FaultsView() {
  return (
    <div class="faults">
      <Active />
      <Inject />
    </div>
  );
}

function Active() {
  const faults = activeFaults.value;
  const clear = (number: number | "all") => link.ask("clear", "", { number }).catch(notifyError);
  return (
    <section class="card" aria-label="Active faults">
      <div class="card-head">
        <h2>Active faults</h2>
        <span class="soft">{faults.length || "none"}</span>
        <button type="button" class="push" disabled={!faults.length || !may("admin")} onClick={() => void clear("all")}>
          Clear all
        </button>
      </div>
      {faults.length > 0 && (
        <div class="scroll-x" tabIndex={0} role="region" aria-label="Table of active faults">
          <table>
            <thead>
              <tr>
                <th scope="col" class="num">
                  number
                </th>
                <th scope="col">kind</th>
                <th scope="col">on</th>
                <th scope="col">parameters</th>
                <th scope="col">since</th>
                <th scope="col">
                  <span class="out-of-sight">clear</span>
                </th>
              </tr>
            </thead>
            <tbody>
              {faults.map((fault) => (
                <tr key={fault.number}>
                  <td class="num">{fault.number}</td>
                  <th scope="row" class="mono">
                    {fault.kind}
                  </th>
                  <td class="place">{fault.target}</td>
                  <td class="mono soft">{parametersText(fault.parameters)}</td>
                  <td class="mono soft">{fault.begin_s === null ? "" : `${fault.begin_s.toFixed(1)} s`}</td>
                  <td>
                    <button
                      type="button"
                      disabled={!may("admin")}
                      aria-label={`Clear fault ${fault.number}, ${fault.kind} on ${fault.target}`}
                      onClick={() => void clear(fault.number)}
                    >
                      Clear
                    </button>
                  </td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </section>
  );
}

function parametersText(parameters: Record<string, unknown>): string {
  return Object.entries(parameters)
    .filter(([name, value]) => value !== 0 || !["seed", "start_s", "for_s"].includes(name))
    .map(([name, value]) => `${name} ${String(value)}`)
    .join(", ");
}

/** Timing that every kind has, where the door's table leaves it out. */
const TIMING: ParameterRow[] = [
  { name: "start_s", summary: "how long after the injection it begins", unit: "s", minimum: 0, maximum: 86400, default: 0 },
  { name: "for_s", summary: "how long it lasts; 0: until it is cleared", unit: "s", minimum: 0, maximum: 86400, default: 0 },
];

function Inject() {
  const kinds = hello.value?.fault_kinds ?? [];
  const kind = kinds.find((each) => each.name === chosenKind.value) ?? kinds[0];
  const layers = [...new Set(kinds.map((each) => each.layer))];
  if (!kind) return null;
  return (
    <section class="card" aria-label="Inject a fault">
      <div class="card-head">
        <h2>Inject a fault</h2>
      </div>
      <div class="fault-kinds">
        {layers.map((layer) => (
          <div key={layer} class="fault-layer" role="group" aria-label={`Faults of the layer ${layer}`}>
            <span class="soft">{layer}</span>
            {kinds
              .filter((each) => each.layer === layer)
              .map((each) => (
                <button
                  key={each.name}
                  type="button"
                  class="mono"
                  aria-pressed={each === kind}
                  title={each.summary}
                  onClick={() => (chosenKind.value = each.name)}
                >
                  {each.name}
                </button>
              ))}
          </div>
        ))}
      </div>
      <KindForm key={kind.name} kind={kind} />
    </section>
  );
}

function KindForm({ kind }: { kind: FaultKindRow }) {
  const list = useId();
  const bench = hello.value;
  if (!bench) return null;
  const places = placesOf(kind, bench);
  const place = chosenPlace.value || places[0] || "";
  const hasTiming = kind.parameters.some((row) => row.name === "for_s");
  const rows = hasTiming ? kind.parameters : [...kind.parameters, ...TIMING];
  const inject = async (values: Record<string, unknown>) => {
    try {
      const answer = await link.ask("inject", place, { fault: kind.name, parameters: values });
      notify(kind.is_once ? `${kind.name} happened on ${place}.` : `${kind.name} is on ${place} now, as fault ${answer.number}.`);
      if (kind.is_once) markOnce(kind.name, place);
    } catch (error) {
      notifyError(error);
    }
  };
  return (
    <div class="kind-form">
      <p>
        <strong class="mono">{kind.name}</strong>{" "}
        <span class="soft">
          {kind.summary}
          {kind.is_once && " (once)"}
        </span>
      </p>
      <div class="parameter">
        <label htmlFor={`${list}-on`}>
          <span class="mono">on</span>
        </label>
        <input
          id={`${list}-on`}
          list={list}
          autocomplete="off"
          spellcheck={false}
          value={place}
          aria-describedby={`${list}-hint`}
          onInput={(event) => (chosenPlace.value = event.currentTarget.value)}
        />
        <span class="soft" id={`${list}-hint`}>
          {places.length ? `such as ${places.slice(0, 4).join(", ")}` : "this bench has no such place"}
        </span>
        <datalist id={list}>
          {places.map((each) => (
            <option key={each} value={each} />
          ))}
        </datalist>
      </div>
      <ParameterForm
        rows={rows}
        given={forms.of(kind.name)}
        onType={(texts) => forms.put(kind.name, texts)}
        action={`Inject ${kind.name}`}
        isDanger
        isDisabled={!may("admin")}
        why={may("admin") ? "" : "This needs the role admin."}
        onSubmit={inject}
      />
      {!may("admin") && <p class="soft">This needs the role admin.</p>}
    </div>
  );
}

function markOnce(kind: string, target: string): void {
  const at_s = benchTime_s();
  faultMarks.value = [...faultMarks.value, { number: onceNumber--, kind, target, begin_s: at_s, end_s: at_s }];
}

export const faultsView: ViewEntry = { id: "faults", title: "Faults", View: FaultsView };
