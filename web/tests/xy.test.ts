import { expect, it } from "vitest";
import { Ring } from "../src/model/ring";
import { nearestTime, valueAt, xyPoints, xyRanges, xyRoom, type XyRanges, type XySource } from "../src/model/xy";

const TURN = 2 * Math.PI;

/** Samples of a circle: x and y; by extremes of intervals, or of moments. */
function circle(rate_Hz: number, isExtremes: boolean, from_s = 0): Ring {
  const ring = new Ring(16_000, 3);
  for (let number = 0; number < 2 * rate_Hz; number++) {
    const at_s = from_s + number / rate_Hz;
    if (!isExtremes) {
      ring.push(Float64Array.of(at_s, Math.cos(TURN * at_s), Math.sin(TURN * at_s)), 1, 3);
      continue;
    }
    const seen = [0, 0.25, 0.5, 0.75].map((part) => at_s + part / rate_Hz);
    const [xs, ys] = [seen.map((each) => Math.cos(TURN * each)), seen.map((each) => Math.sin(TURN * each))];
    ring.push(Float64Array.of(at_s, Math.min(...xs), Math.min(...ys), seen[3]!, Math.max(...xs), Math.max(...ys)), 2, 3);
  }
  return ring;
}

function source(ring: Ring, column: number, isExtremes: boolean): XySource {
  return { ring, column, isExtremes };
}

function worst(x: XySource, y: XySource): number {
  const out = xyRoom(4000);
  xyPoints(x, y, 0.5, 1.5, out);
  expect(out.count).toBeGreaterThan(90);
  let most = 0;
  for (let at = 0; at < out.count; at++) most = Math.max(most, Math.abs(Math.hypot(out.x[at]!, out.y[at]!) - 1));
  return most;
}

it("draws a circle of one device, or of two with other rates and ways of sampling", () => {
  for (const isExtremes of [false, true]) {
    const ring = circle(1000, isExtremes);
    expect(worst(source(ring, 1, isExtremes), source(ring, 2, isExtremes))).toBeLessThan(0.01);
    for (const [rate_Hz, isOther] of [
      [1000, true],
      [1000, false],
      [6667, false],
      [150, true],
    ] as const) {
      const limit = rate_Hz < 1000 ? 0.06 : 0.01;
      expect(worst(source(ring, 1, isExtremes), source(circle(rate_Hz, isOther, -0.003), 2, isOther))).toBeLessThan(limit);
    }
  }
});

it("takes the newest where there are more points than room, and says from when on", () => {
  const ring = circle(1000, true);
  const out = xyRoom(100);
  const from_s = xyPoints(source(ring, 1, true), source(ring, 2, true), 0, 2, out);
  expect(out.count).toBeLessThanOrEqual(100);
  expect(from_s).toBeCloseTo(1.9, 2);
  expect(out.at_s[out.count - 1]).toBeCloseTo(2, 2);
});

it("has no points of what is not there", () => {
  const ring = circle(100, false);
  const out = xyRoom(100);
  for (const column of [0, 7]) {
    xyPoints(source(ring, column, false), source(ring, 1, false), 0, 1, out);
    expect(out.count).toBe(0);
  }
  expect(valueAt(source(ring, 1, false), -1)).toBeNaN();
  expect(valueAt(source(ring, 1, false), 5)).toBeNaN();
});

it("makes a unit as long in both axes, and finds the point of a click", () => {
  const ring = circle(100, false);
  const out = xyRoom(1000);
  xyPoints(source(ring, 1, false), source(ring, 2, false), 0, 1, out);
  const ranges: XyRanges = { x: [0, 1], y: [0, 1] };
  xyRanges(out, [0.1, 0.1], [400, 200], ranges);
  expect((ranges.x[1] - ranges.x[0]) / 400).toBeCloseTo((ranges.y[1] - ranges.y[0]) / 200, 9);
  expect(ranges.y[0]).toBeLessThanOrEqual(-1);
  expect(nearestTime(out, ranges, 0.1, 3)).toBeCloseTo(0.25, 1);
  out.count = 0;
  expect(nearestTime(out, ranges, 0, 0)).toBeNaN();
});
