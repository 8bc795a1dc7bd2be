/** How large a text is, and what the bench takes: said before it is sent. */

import { effect, type ReadonlySignal, signal } from "@preact/signals";

/** Room for what stands around texts in their message. */
const AROUND_BYTES = 1000;
/** Long texts are measured so long after the last key. */
const LONG_CHARACTERS = 100_000;
const PAUSE_MS = 300;

/** Bytes of texts in a message, and the most that the bench takes. */
export function measured(texts: () => string[], message_bytes: () => number | undefined): ReadonlySignal<{ bytes: number; most: number }> {
  const size = signal({ bytes: 0, most: Number.POSITIVE_INFINITY });
  let timer: ReturnType<typeof setTimeout> | undefined;
  effect(() => {
    const now = texts();
    const most = (message_bytes() ?? Number.POSITIVE_INFINITY) - AROUND_BYTES;
    const measure = () => (size.value = { bytes: new TextEncoder().encode(JSON.stringify(now)).length, most });
    clearTimeout(timer);
    if (now.some((text) => text.length > LONG_CHARACTERS)) timer = setTimeout(measure, PAUSE_MS);
    else measure();
  });
  return size;
}

const NEAR = 0.5;

export function TextSize({ bytes, most, what }: { bytes: number; most: number; what: string }) {
  if (bytes < most * NEAR) return null;
  const said = `${bytes.toLocaleString("en")} of ${most.toLocaleString("en")} bytes`;
  return bytes > most ? (
    <p class="problem" role="status">
      {what} is too long for the bench: {said}. Make two of it, or raise message_kb of the bench's web.
    </p>
  ) : (
    <p class="soft">{said} that the bench takes.</p>
  );
}
