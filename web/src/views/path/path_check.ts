/** What the bench says of the texts as they are typed, and how much it takes. */

import { computed, effect, signal } from "@preact/signals";
import { readCheck } from "../../model/drawing";
import { measured } from "../../parts/text_size";
import { hello, link } from "../../store";
import { ask, checked, drafts, isChecked, isPlanned, isPlanning, refused, verdict } from "./path_state";

/** Why the texts could not be checked; empty: they could. */
export const unchecked = signal("");

export const size = measured(
  () => [drafts.program.value.text, drafts.machine.value.text],
  () => hello.value?.message_bytes,
);
export const fits = computed(() => size.value.bytes <= size.value.most);

/** Texts are checked so long after the last key, long ones later. */
const PAUSE_MS = 600;
const LONG_PAUSE_MS = 2500;
const LONG_CHARACTERS = 100_000;

const isReady = computed(() => hello.value !== null && link.state.value === "open" && fits.value && !isPlanning.value);
const isWanted = computed(() => isReady.value && !isChecked.value && !isPlanned.value && drafts.machine.value.text.trim() !== "");

async function check(): Promise<void> {
  try {
    const { texts, answer } = await ask(true);
    const read = readCheck(answer);
    checked.value = texts;
    refused.value = typeof read === "string" ? null : read;
    verdict.value = typeof read === "string" ? read : "";
    unchecked.value = "";
  } catch (error) {
    unchecked.value = error instanceof Error ? error.message : String(error);
  }
}

/** Check the texts whenever they, or the bench, have changed, one check at a time; answers what ends it. */
export function checkAsTyped(): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let isBusy = false;
  let isEnded = false;
  let before = hello.peek();
  const later = () => {
    clearTimeout(timer);
    if (isBusy || isEnded || !isWanted.peek()) return;
    timer = setTimeout(() => void now(), drafts.program.peek().text.length > LONG_CHARACTERS ? LONG_PAUSE_MS : PAUSE_MS);
  };
  const now = async () => {
    isBusy = true;
    await check();
    isBusy = false;
    if (!unchecked.peek()) later();
  };
  const stop = effect(() => {
    if (hello.value !== before) checked.value = ["", ""];
    before = hello.value;
    void [drafts.program.value, drafts.machine.value, isWanted.value];
    later();
  });
  return () => {
    isEnded = true;
    clearTimeout(timer);
    stop();
  };
}
