/** What can be asked of a device, each verb as a form. */

import { KeptForms, keptTexts } from "../../kept";
import { answerText } from "../../model/answer_text";
import { notify, notifyError } from "../../parts/notices";
import { ParameterForm } from "../../parts/parameter_form";
import type { DeviceRow, VerbRow } from "../../model/door";
import { link, may, whyNot } from "../../store";

/** The verb that was chosen last, by profile. */
const chosen = keptTexts("bench.verbs");
const forms = new KeptForms("bench.forms");

export function Verbs({ device }: { device: DeviceRow }) {
  const names = Object.keys(device.verbs);
  const name = names.find((each) => each === chosen.value[device.profile]) ?? names[0];
  const verb = name === undefined ? undefined : device.verbs[name];
  if (name === undefined || !verb) return <p class="empty">Nothing can be asked of this device.</p>;
  return (
    <div class="verbs">
      <div class="verb-names" role="group" aria-label="Verbs">
        {names.map((each) => (
          <button
            key={each}
            type="button"
            class="mono"
            aria-pressed={each === name}
            title={device.verbs[each]?.summary}
            onClick={() => (chosen.value = { ...chosen.value, [device.profile]: each })}
          >
            {each}
          </button>
        ))}
      </div>
      <VerbForm key={`${device.name} ${name}`} device={device} name={name} verb={verb} />
    </div>
  );
}

function VerbForm({ device, name, verb }: { device: DeviceRow; name: string; verb: VerbRow }) {
  const isAllowed = may(verb.role);
  const form = `${device.name} ${name}`;
  const carryOut = async (values: Record<string, unknown>) => {
    try {
      const answer = await askVerb(device.name, name, values);
      notify(`${device.name} ${name}: ${answerText(answer, verb, device.fields) || "done"}`);
    } catch (error) {
      notifyError(error);
    }
  };
  return (
    <>
      <p class="verb-about">
        <strong class="mono">{name}</strong> <span class="soft">{verb.summary}</span>
      </p>
      <ParameterForm
        rows={verb.parameters}
        given={forms.of(form)}
        onType={(texts) => forms.put(form, texts)}
        action={name}
        isDisabled={!isAllowed}
        why={isAllowed ? `${name} ${device.name}` : whyNot(verb.role)}
        onSubmit={carryOut}
      />
      {!isAllowed && <p class="soft">{whyNot(verb.role)}</p>}
    </>
  );
}

/** Carry out a verb of a device. Throws Refused. */
export function askVerb(device: string, name: string, parameters: Record<string, unknown>): Promise<unknown> {
  return link.ask("do", device, { name, parameters });
}
