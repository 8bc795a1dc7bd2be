/** The help: what the words of this page mean, and its keys. */

import { signal } from "@preact/signals";
import { whenLoaded } from "./when_loaded";

const isOpen = signal(false);
const WordsDialog = whenLoaded(async () => (await import("./help_dialog")).WordsDialog);

export function openHelp(): void {
  isOpen.value = true;
}

export function HelpDialog() {
  return isOpen.value ? <WordsDialog close={() => (isOpen.value = false)} /> : null;
}
