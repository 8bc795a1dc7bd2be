/** Short messages at the lower edge: what was refused, what was done. Screen readers say them. */

import { signal } from "@preact/signals";
import { Refused } from "../net/protocol";

interface Notice {
  key: number;
  text: string;
  isError: boolean;
}

const notices = signal<Notice[]>([]);
const SHOWN_MS = 8000;
const MOST = 4;
let nextKey = 1;

/** Called with each message: it goes from the screen, and may stay elsewhere. */
export const noticeListeners: ((text: string, isError: boolean) => void)[] = [];

export function notify(text: string, isError = false): void {
  for (const listener of noticeListeners) listener(text, isError);
  const key = nextKey++;
  notices.value = [...notices.value.slice(1 - MOST), { key, text, isError }];
  window.setTimeout(() => dismiss(key), SHOWN_MS);
}

/** Show why something was refused. */
export function notifyError(error: unknown): void {
  notify(error instanceof Refused || error instanceof Error ? error.message : String(error), true);
}

function dismiss(key: number): void {
  notices.value = notices.value.filter((notice) => notice.key !== key);
}

export function Notices() {
  return (
    <div class="notices" role="status" aria-live="polite">
      {notices.value.map((notice) => (
        <div key={notice.key} class={notice.isError ? "notice is-error" : "notice"}>
          <span>{notice.text}</span>
          <button type="button" class="plain" aria-label="Close this message" onClick={() => dismiss(notice.key)}>
            ×
          </button>
        </div>
      ))}
    </div>
  );
}
