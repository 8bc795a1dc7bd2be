/** How large a text is, and what the bench takes: said before it is sent. */

const NEAR = 0.5;

export function TextSize({ bytes, most, what }: { bytes: number; most: number; what: string }) {
  if (bytes < most * NEAR) return null;
  const said = `${bytes.toLocaleString("en")} of ${most.toLocaleString("en")} bytes`;
  return bytes > most ? (
    <p class="problem" role="status">
      {what} is too long for the bench: {said}. Make two of it.
    </p>
  ) : (
    <p class="soft">{said} that the bench takes.</p>
  );
}
