/** Three things to try on a bench, each with the command that does it in a shell. It stays away when it was dismissed. */

import { useState } from "preact/hooks";
import { keptText } from "../../kept";
import { type FirstStep, firstSteps } from "../../model/first_steps";
import { notify, notifyError } from "../../parts/notices";
import { go } from "../../router";
import { hello, link, may, status } from "../../store";
import { detailTab } from "./detail_tab";

/** "hidden": they were dismissed. */
export const stepsKept = keptText("overview.steps");
const ACTIONS: Record<FirstStep["kind"], string> = { turn: "Turn it", type: "Open its terminal", break: "Break it" };

export function FirstSteps({ isShort }: { isShort: boolean }) {
  const bench = hello.value;
  if (stepsKept.value || !bench) return null;
  const steps = firstSteps(bench, status.value, may);
  if (!steps.length) return null;
  return (
    <section class="card first-steps" aria-label="Things to try">
      <div class="first-head">
        <h2>{isShort ? "Try this" : "New here? Try this; each can be done in a shell, too."}</h2>
        <button type="button" class="plain push" aria-label="Dismiss the things to try" title="Dismiss" onClick={() => (stepsKept.value = "hidden")}>
          ×
        </button>
      </div>
      {steps.map((step) => (
        <Step key={step.kind} step={step} isShort={isShort} />
      ))}
    </section>
  );
}

function Step({ step, isShort }: { step: FirstStep; isShort: boolean }) {
  const [isBusy, setBusy] = useState(false);
  const carryOut = async () => {
    if (!step.requests.length) {
      detailTab.value = "terminal";
      go("bench", step.device);
      return;
    }
    setBusy(true);
    try {
      for (const { operation, target, given } of step.requests) await link.request({ do: "ask", operation, target, given, ...link.soon() });
      notify(`${step.title}: done`);
    } catch (error) {
      notifyError(error);
    } finally {
      setBusy(false);
    }
  };
  return (
    <div class="first-step">
      <button type="button" class="primary" disabled={isBusy} onClick={() => void carryOut()}>
        {step.title}
      </button>
      {!isShort && <p class="soft">{step.about}</p>}
      <pre tabIndex={0} role="region" aria-label={`${ACTIONS[step.kind]} in a shell`}>
        {step.commands.join(isShort ? " && " : "\n")}
      </pre>
    </div>
  );
}
