/** What can be asked of a device, each verb as a form. */

import { signal } from "@preact/signals";
import { notify, notifyError } from "../../parts/notices";
import { ParameterForm } from "../../parts/parameter_form";
import type { DeviceRow, VerbRow } from "../../model/door";
import { link, may } from "../../store";

/** Verbs that are operations of their own too, and everywhere the same. */
const chosen = signal<Record<string, string>>({});

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
  const carryOut = async (values: Record<string, unknown>) => {
    try {
      const answer = await askVerb(device.name, name, values);
      notify(`${device.name} ${name}: ${answerText(answer)}`);
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
        action={name}
        isDisabled={!isAllowed}
        why={isAllowed ? `${name} ${device.name}` : `This needs the role ${verb.role}.`}
        onSubmit={carryOut}
      />
      {!isAllowed && <p class="soft">This needs the role {verb.role}.</p>}
    </>
  );
}

/** Carry out a verb of a device. Throws Refused. */
export function askVerb(device: string, name: string, parameters: Record<string, unknown>): Promise<unknown> {
  return link.ask("do", device, { name, parameters });
}

function answerText(answer: unknown): string {
  if (typeof answer !== "object" || answer === null) return "done";
  const told = Object.entries(answer).filter(([name]) => !name.endsWith("_ns"));
  return told.length ? told.map(([name, value]) => `${name} ${String(value)}`).join(", ") : "done";
}
