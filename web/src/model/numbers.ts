/** Numbers as text, and sizes and times for people. Pure. */

/** Format a value with as many digits as its unit is worth; "–" where there is none. */
export function shown(value: number | null | undefined, digits = 2): string {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (Math.abs(value) >= 1e9) return signed(value.toExponential(2));
  return signed(value.toFixed(digits));
}

function signed(text: string): string {
  return /^-0(\.0*)?$/.test(text) ? text.slice(1) : text.replace("-", "−");
}

const DIGITS: Record<string, number> = { deg: 2, rpm: 1, Nm: 4, A: 3, V: 2, J: 3, Hz: 2, s: 3 };

/** Digits behind the point that values of a unit are shown with. */
export function digitsOf(unit: string): number {
  return DIGITS[unit] ?? (unit === "" || unit === "count" || unit === "pulse" ? 0 : 2);
}

/** Format a bound so that it can be read: 1000000, 0.001, 2^53. */
export function plain(bound: number): string {
  if (bound >= 1e12 && Number.isInteger(Math.log2(bound))) return `2^${Math.log2(bound)}`;
  return Number.isInteger(bound) && Math.abs(bound) < 1e12 ? String(bound) : String(Number(bound.toPrecision(6)));
}

/** Format a rate of bytes: "1.2 kB/s". */
export function byteRate(bytes_per_s: number): string {
  if (!(bytes_per_s > 0)) return "0 B/s";
  if (bytes_per_s < 1000) return `${Math.round(bytes_per_s)} B/s`;
  if (bytes_per_s < 1e6) return `${(bytes_per_s / 1000).toFixed(1)} kB/s`;
  return `${(bytes_per_s / 1e6).toFixed(1)} MB/s`;
}
