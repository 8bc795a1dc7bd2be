/** The form of one kind of fault at one place, and what is kept of such forms. */

import { KeptForms, KeptTogether } from "../../kept";
import type { FaultKindRow } from "../../model/door";
import { checkAll, type ParameterRow } from "../../model/parameters";
import { notify, notifyError } from "../../parts/notices";
import { ParameterForm } from "../../parts/parameter_form";
import { go } from "../../router";
import { benchTime_s, faultMarks, hello, link, may } from "../../store";
import { FaultDrawing } from "./fault_drawing";
import { familyOf, type Preset, readPresets, withPreset } from "./fault_places";

const forms = new KeptForms("faults.forms");
const names = new KeptForms("faults.names");
const presets = new KeptTogether<readonly Preset[]>("faults.presets", () => [], readPresets);
/** Kinds that happen once are never listed as active: their marks are made here, and last a moment. */
let onceNumber = -1;

const DAY_S = 86400;
/** Timing that every kind has, where the door's table leaves it out. */
const TIMING: ParameterRow[] = [
  { name: "start_s", summary: "how long after the injection it begins", unit: "s", minimum: 0, maximum: DAY_S, default: 0 },
  { name: "for_s", summary: "for so long; 0: until it is cleared", unit: "s", minimum: 0, maximum: DAY_S, default: 0 },
  {
    name: "every_s",
    summary: "then again every so often, from one beginning to the next; 0: it comes once",
    unit: "s",
    minimum: 0,
    maximum: DAY_S,
    default: 0,
  },
];

function rowsOf(kind: FaultKindRow): ParameterRow[] {
  return [...kind.parameters, ...TIMING].filter((row) => !(kind.is_once && row.name === "for_s"));
}

async function inject(kind: FaultKindRow, place: string, values: Record<string, unknown>): Promise<void> {
  try {
    const { number } = await link.ask("inject", place, { fault: kind.name, parameters: values });
    const isOver = kind.is_once && !values["every_s"];
    notify(isOver ? `${kind.title}: it happened on ${place}.` : `${kind.title}: on ${place} now, as fault ${number}.`);
    if (isOver) markOnce(kind.name, place);
  } catch (error) {
    notifyError(error);
  }
}

function markOnce(kind: string, target: string): void {
  const at_s = benchTime_s();
  faultMarks.value = [...faultMarks.value, { number: onceNumber--, kind, target, begin_s: at_s, end_s: at_s }];
}

export function FaultForm({ kind, place }: { kind: FaultKindRow; place: string }) {
  const [name, setName] = names.field(kind.name, "preset");
  const why = may("admin") ? "" : "This needs the role admin.";
  const keep = () => {
    presets.value = withPreset(presets.peek(), { name: name.trim() || `${kind.title} on ${place}`, kind: kind.name, place, texts: forms.of(kind.name) });
    setName("");
  };
  return (
    <section class="card fault-form" aria-label="Inject a fault">
      <div class="row">
        <FaultDrawing family={familyOf(kind.name)} />
        <h2>
          {kind.title} on {place}
        </h2>
      </div>
      <p>
        {sentence(kind.summary)}
        {kind.is_once && !/\bonce\b/.test(kind.summary) ? " It happens once." : ""} <span class="mono soft">{kind.name}</span>
      </p>
      <ParameterForm
        rows={rowsOf(kind)}
        given={forms.of(kind.name)}
        onType={(texts) => forms.put(kind.name, texts)}
        action={`Inject ${kind.name}`}
        isDanger
        isDisabled={!may("admin")}
        why={why}
        onSubmit={(values) => inject(kind, place, values)}
      />
      {why && <p class="soft">{why}</p>}
      <form class="row" onSubmit={(event) => (event.preventDefault(), keep())}>
        <input
          aria-label="Name of the preset"
          placeholder={`${kind.title} on ${place}`}
          value={name}
          maxLength={80}
          autocomplete="off"
          onInput={(event) => setName(event.currentTarget.value)}
        />
        <button type="submit">Keep as a preset</button>
      </form>
    </section>
  );
}

function sentence(text: string): string {
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}.`;
}

/** Faults that were kept: one press injects each. */
export function Presets({ choose }: { choose(kind: string): void }) {
  const kinds = hello.value?.fault_kinds ?? [];
  if (!presets.value.length) return null;
  const run = (preset: Preset) => {
    const kind = kinds.find(({ name }) => name === preset.kind);
    if (!kind) {
      notify(`This bench knows no fault ${preset.kind}.`, true);
      return;
    }
    const { values, problems } = checkAll(rowsOf(kind), filled(rowsOf(kind), preset.texts));
    if (!Object.keys(problems).length) void inject(kind, preset.place, values);
    else edit(preset);
  };
  const edit = (preset: Preset) => {
    forms.put(preset.kind, preset.texts);
    choose(preset.kind);
    go("faults", preset.place);
  };
  return (
    <section class="card" aria-label="Presets">
      <h2>Presets</h2>
      <ul class="presets">
        {presets.value.map((preset) => (
          <li key={preset.name} class="row">
            <button type="button" class="danger" disabled={!may("admin")} aria-label={`Inject ${preset.name}`} onClick={() => run(preset)}>
              Inject
            </button>
            <button type="button" class="plain" title={`${preset.kind} on ${preset.place}`} onClick={() => edit(preset)}>
              {preset.name}
            </button>
            <button
              type="button"
              class="plain"
              aria-label={`Forget ${preset.name}`}
              onClick={() => (presets.value = presets.peek().filter((each) => each !== preset))}
            >
              ×
            </button>
          </li>
        ))}
      </ul>
    </section>
  );
}

/** Texts of all rows: those that were typed, else the defaults. */
function filled(rows: readonly ParameterRow[], texts: Readonly<Record<string, string>>): Record<string, string> {
  return Object.fromEntries(rows.map(({ name, default: usual }) => [name, texts[name] ?? (usual === null || usual === undefined ? "" : String(usual))]));
}
