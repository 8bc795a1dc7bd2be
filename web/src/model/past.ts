/** What a recording tells of a run: marks of a time line, rows of samples, words for times. Pure. */

export const LANES = ["faults", "runs", "verbs", "typed", "refusals", "stops", "lateness", "trouble", "reloads", "clients"] as const;

/** Something that happened. `to_s`: null, it lasts. */
export interface PastMark {
  lane: string;
  from_s: number;
  to_s: number | null;
  of: string;
  text: string;
}

/** Read the marks of an answer of `past`; what has another form is left out. */
export function readMarks(raw: unknown): PastMark[] {
  return (Array.isArray(raw) ? (raw as unknown[]) : []).flatMap((each) => {
    const { lane, from_ns, to_ns, of, text } = (each ?? {}) as Record<string, unknown>;
    if (typeof lane !== "string" || typeof from_ns !== "number" || typeof text !== "string") return [];
    return [{ lane, from_s: from_ns / 1e9, to_s: typeof to_ns === "number" ? to_ns / 1e9 : null, of: String(of ?? ""), text }];
  });
}

/** Decode rows of numbers of 64 bits, little-endian, from base64. */
export function readRows(data: string): Float64Array {
  const text = atob(data);
  const bytes = new Uint8Array(text.length);
  for (let at = 0; at < text.length; at++) bytes[at] = text.charCodeAt(at);
  return new Float64Array(bytes.buffer, 0, bytes.length >> 3);
}

/** Time of a run for people: 00:12:03.250. */
export function timeText(at_s: number): string {
  const ms = Math.max(Math.round(at_s * 1000), 0);
  const two = (value: number) => String(Math.floor(value)).padStart(2, "0");
  return `${two(ms / 3_600_000)}:${two((ms / 60_000) % 60)}:${two((ms / 1000) % 60)}.${String(ms % 1000).padStart(3, "0")}`;
}

/** Say how long ago something was: 12.5 s, 3 min 20 s, 2 h 5 min. */
export function agoText(ago_s: number): string {
  if (ago_s < 60) return `${ago_s.toFixed(1)} s`;
  const s = Math.round(ago_s);
  if (s < 3600) return `${Math.floor(s / 60)} min ${s % 60} s`;
  return `${Math.floor(s / 3600)} h ${Math.floor((s % 3600) / 60)} min`;
}

/** Mark that is next to a time, in a direction: the first that begins behind it, or the last before it. */
export function markBeside(marks: readonly PastMark[], at_s: number, isBack: boolean): PastMark | undefined {
  const beside = marks.filter((mark) => (isBack ? mark.from_s < at_s - 1e-6 : mark.from_s > at_s + 1e-6));
  return beside.reduce<PastMark | undefined>(
    (best, mark) => (!best || (isBack ? mark.from_s > best.from_s : mark.from_s < best.from_s) ? mark : best),
    undefined,
  );
}

const STEPS_s = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60, 120, 300, 600, 1800, 3600, 7200, 21_600, 86_400];

/** Times for the marks of an axis over a window, at most so many. */
export function ticks(from_s: number, to_s: number, most: number): number[] {
  const step = STEPS_s.find((each) => (to_s - from_s) / each <= most) ?? (to_s - from_s) / most;
  const made: number[] = [];
  for (let at = Math.ceil(from_s / step - 1e-9); at * step <= to_s + 1e-9; at++) made.push(at * step || 0);
  return made;
}
