import { expect, it } from "vitest";
import { between } from "../src/model/between";
import { Ring } from "../src/model/ring";

function ringOf(value: (at_s: number) => number, rows = 1001, step_s = 0.001): Ring {
  const ring = new Ring(4000, 2);
  for (let row = 0; row < rows; row++) ring.push(Float64Array.of(row * step_s, value(row * step_s)), 1, 2);
  return ring;
}

it("finds mean, rms, extremes and slope between two times, in any order", () => {
  const line = between(
    ringOf((at_s) => 3 + 2 * at_s),
    1,
    0.75,
    0.25,
  );
  expect(line.mean).toBeCloseTo(4, 6);
  expect(line.slope).toBeCloseTo(2, 6);
  expect([line.least, line.most].map((value) => value.toFixed(3))).toEqual(["3.500", "4.500"]);
  const wave = between(
    ringOf((at_s) => 5 * Math.sin(2 * Math.PI * 10 * at_s)),
    1,
    0,
    1,
  );
  expect(wave.mean).toBeCloseTo(0, 3);
  expect(wave.rms).toBeCloseTo(5 / Math.SQRT2, 2);
});

it("has the rms of a wave that swings faster than its extremes come", () => {
  const ring = new Ring(2000, 2);
  for (let number = 0; number < 500; number++) ring.push(Float64Array.of(number / 100, -1, (number + 0.5) / 100, 1), 2, 2);
  const { mean, rms, most } = between(ring, 1, 0, 5);
  expect(mean).toBeCloseTo(0, 2);
  expect(rms).toBeCloseTo(1 / Math.sqrt(3), 2); // of a triangle: what extremes alone can tell
  expect(most).toBe(1);
});

it("passes over what is missing, and has no figures of nothing", () => {
  const ring = ringOf(() => 2, 10, 0.1);
  ring.gap();
  ring.push(Float64Array.of(5, 4, 6, 4), 2, 2);
  const { mean, most } = between(ring, 1, 0, 6);
  expect(most).toBe(4);
  expect(mean).toBeCloseTo((0.9 * 2 + 1 * 4) / 1.9, 6);
  expect(between(ring, 1, 2, 3).mean).toBeNaN();
  expect(between(ring, 7, 0, 6).mean).toBeNaN();
  expect(between(ring, 1, 5, 5).mean).toBeNaN();
});
