/** The help: what the words of this page mean, and its keys. */

import { useEffect, useRef } from "preact/hooks";
import { signal } from "@preact/signals";
import { KEYS, WORDS } from "./words";

const isOpen = signal(false);

export function openHelp(): void {
  isOpen.value = true;
}

export function HelpDialog() {
  const dialog = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    if (isOpen.value) dialog.current?.showModal();
    else dialog.current?.close();
  }, [isOpen.value]);
  return (
    <dialog ref={dialog} class="help" aria-labelledby="help-title" onClose={() => (isOpen.value = false)}>
      <div class="dialog-head">
        <h2 id="help-title">What the words mean</h2>
        <button type="button" onClick={() => (isOpen.value = false)}>
          Close
        </button>
      </div>
      <div class="dialog-body" tabIndex={0} role="region" aria-label="Words and keys">
        <dl class="words">
          {WORDS.map(([word, meaning]) => (
            <div key={word}>
              <dt>{word}</dt>
              <dd>{meaning}</dd>
            </div>
          ))}
        </dl>
        <h3>Keys</h3>
        <dl class="words">
          {KEYS.map(([key, meaning]) => (
            <div key={key}>
              <dt>
                <kbd>{key}</kbd>
              </dt>
              <dd>{meaning}</dd>
            </div>
          ))}
        </dl>
      </div>
    </dialog>
  );
}
