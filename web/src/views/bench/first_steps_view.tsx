/** Three things to try on a bench, each with the command that does it in a shell. It stays away when it was dismissed. */

import { useState } from "preact/hooks";
import { keptText } from "../../kept";
import { stepBefore, type FirstStep, firstSteps } from "../../model/first_steps";
import { notify } from "../../parts/notices";
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
  const [why, setWhy] = useState("");
  const carryOut = async (requests: FirstStep["requests"], done: string) => {
    if (!requests.length) {
      detailTab.value = "terminal";
      go("bench", step.device);
      return;
    }
    setBusy(true);
    setWhy("");
    try {
      for (const { operation, target, given } of requests) await link.request({ do: "ask", operation, target, given, ...link.soon() });
      notify(done);
    } catch (error) {
      setWhy(error instanceof Error ? error.message : String(error));
    } finally {
      setBusy(false);
    }
  };
  const first = stepBefore(step, why);
  const commands = first ?? step;
  return (
    <div class="first-step">
      <button type="button" class="primary" disabled={isBusy} onClick={() => void carryOut(step.requests, `${step.title}: done`)}>
        {step.title}
      </button>{" "}
      {first && (
        <button type="button" disabled={isBusy} onClick={() => void carryOut(first.requests, `${step.device} calibrates: then turn it`)}>
          {first.title}
        </button>
      )}
      {why ? (
        <p class="problem" role="alert">
          {why}
        </p>
      ) : (
        !isShort && <p class="soft">{step.about}</p>
      )}
      <pre tabIndex={0} role="region" aria-label={`${ACTIONS[step.kind]} in a shell`}>
        {commands.commands.join(isShort ? " && " : "\n")}
      </pre>
    </div>
  );
}
