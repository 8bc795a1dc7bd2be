import { describe, expect, it } from "vitest";
import { beside, copyWhere, decimate, display, windowWithin } from "../src/model/decimate";
import { Ring } from "../src/model/ring";
import { csvOf } from "../src/model/samples_csv";
import { type Layer, layerOver, samplingText } from "../src/model/sampling";

const FINE = { interval_s: 1 / 1000, isExtremes: false };
const COARSE = { interval_s: 1 / 60, isExtremes: true };

function layer(sampling: Layer["sampling"], from_s: number, to_s: number, value: (at_s: number) => number): Layer {
  const ring = new Ring(100_000, 2);
  const { interval_s, isExtremes } = sampling;
  for (let number = 0; number * interval_s < to_s - from_s; number++) {
    const begin_s = from_s + number * interval_s;
    if (!isExtremes) {
      ring.push(Float64Array.of(begin_s, value(begin_s)), 1, 2);
      continue;
    }
    const seen = Array.from({ length: 12 }, (_, at) => value(begin_s + (interval_s * at) / 12));
    ring.push(Float64Array.of(begin_s, Math.min(...seen), begin_s + (interval_s * 11) / 12, Math.max(...seen)), 2, 2);
  }
  return { ring, sampling };
}

describe("samplingText", () => {
  it("says the rate, or the interval of extremes", () => {
    expect(samplingText(FINE)).toBe("1000/s");
    expect(samplingText(COARSE)).toBe("min/max of 16.7 ms");
    expect(samplingText({ interval_s: 0.001, isExtremes: true })).toBe("min/max of 1 ms");
    expect(samplingText({ interval_s: 1.25, isExtremes: true })).toBe("min/max of 1.25 s");
    expect(samplingText({ interval_s: 0.00015, isExtremes: false })).toBe("6670/s");
  });
});

describe("layerOver", () => {
  const fine = layer(FINE, 20, 30, Math.sin);
  const coarse = layer(COARSE, 0, 30, Math.sin);

  it("takes the finest of those that reach back far enough", () => {
    expect(layerOver([fine, coarse], 25)).toBe(fine);
    expect(layerOver([fine, coarse], 19)).toBe(coarse);
  });

  it("takes what reaches back furthest where none does, the finest of those alike", () => {
    expect(layerOver([fine, coarse], -5)).toBe(coarse);
    const young = layer(COARSE, 19.99, 30, Math.sin);
    expect(layerOver([fine, young], 15)).toBe(fine);
    const empty = { ring: new Ring(10, 2), sampling: FINE };
    expect(layerOver([empty, young], 15)).toBe(young);
    expect(layerOver([empty], 15)).toBe(empty);
  });
});

describe("what is drawn of a current of 50.25 Hz", () => {
  const current_A = (at_s: number) => 0.8 * Math.sin(2 * Math.PI * 50.25 * at_s);

  it("keeps its size in each pixel, whatever is shown", () => {
    for (const { ring } of [layer({ interval_s: 0.001, isExtremes: true }, 0, 10, current_A), layer(COARSE, 0, 10, current_A)]) {
      const shown = display(ring, 1280);
      const made = decimate(ring, 0, 10, shown);
      expect(made).toBeGreaterThan(600);
      for (let at = 40; at + 8 < made; at += 8) {
        const values = shown[1]!.subarray(at, at + 8);
        expect(Math.max(...values)).toBeGreaterThan(0.75);
        expect(Math.min(...values)).toBeLessThan(-0.75);
      }
    }
  });
});

describe("beside", () => {
  it("puts the extremes of another axis beside the rows that are drawn", () => {
    const own = layer({ interval_s: 0.001, isExtremes: false }, 0, 4, Math.sin).ring;
    const other = layer({ interval_s: 0.001, isExtremes: false }, 1, 3.0005, (at_s) => Math.sign(Math.sin(2 * Math.PI * 100 * at_s + 0.1))).ring;
    const shown = display(own, 256);
    const made = decimate(own, 0, 4, shown);
    const out = new Float64Array(256);
    beside(other, 1, shown[0]!, made, out);
    const at = (at_s: number) => 2 * Math.floor(shown[0]!.subarray(0, made).findIndex((each) => each > at_s) / 2);
    expect(out[at(0.5)]).toBeNaN();
    expect([out[at(2)], out[at(2) + 1]].sort()).toEqual([-1, 1]);
    expect(Math.abs(out[at(3.9)]!)).toBe(1); // it stays as it was
    beside(other, 7, shown[0]!, made, out);
    expect(out.every(Number.isNaN)).toBe(true);
  });

  it("is exact where single rows are drawn", () => {
    const own = layer({ interval_s: 0.001, isExtremes: false }, 0, 0.1, Math.sin).ring;
    const shown = display(own, 256);
    const made = decimate(own, 0, 0.1, shown);
    const out = new Float64Array(256);
    beside(own, 1, shown[0]!, made, out);
    expect([...out.subarray(0, made)]).toEqual([...shown[1]!.subarray(0, made)]);
  });
});

describe("copyWhere", () => {
  it("leaves out extremes of an interval in which the unit changed, whichever is first", () => {
    const modes = [1, 1, 1, 2, 2, 2];
    const out = new Float64Array(6);
    copyWhere([10, 11, 12, 13, 14, 15], modes, (mode) => mode === 1, out);
    expect([...out]).toEqual([10, 11, NaN, NaN, NaN, NaN]);
    copyWhere([10, 11, 12, 13, 14, 15], modes, (mode) => mode === 2, out);
    expect([...out]).toEqual([NaN, NaN, NaN, NaN, 14, 15]);
  });
});

describe("windowWithin", () => {
  it("keeps the length while it moves, and becomes what there is", () => {
    expect(windowWithin(5, 8, 0, 30)).toEqual([5, 8]);
    expect(windowWithin(-2, 1, 0, 30)).toEqual([0, 3]);
    expect(windowWithin(29, 32, 0, 30)).toEqual([27, 30]);
    expect(windowWithin(-1e14, 1e14, 0, 30)).toEqual([0, 30]);
  });
});

describe("csvOf", () => {
  it("has units, and says how the rows were sampled", () => {
    const text = csvOf(
      layer({ interval_s: 0.5, isExtremes: true }, 0, 1, (at_s) => at_s),
      [
        { name: "position_deg", units: ["deg"], column: 1 },
        { name: "r", units: ["deg", "rpm"], column: 1 },
        { name: "mode", units: [""], column: 1 },
      ],
      0,
      0.5,
    );
    const [head, first, ...rest] = text.trimEnd().split("\n");
    expect(head).toBe("at_s,position_deg,r [deg or rpm],mode,sampling");
    expect(first).toBe("0,0,0,0,min/max of 500 ms");
    expect(rest.length).toBe(2);
  });
  it("leaves out the run before, whose clock was another", () => {
    const { ring, sampling } = layer({ interval_s: 0.5, isExtremes: true }, 0, 1, (at_s) => at_s);
    ring.restart();
    ring.push(new Float64Array([0.25, 5]), 1, 2);
    const rows = csvOf({ ring, sampling }, [{ name: "position_deg", units: ["deg"], column: 1 }], -100, 100)
      .trimEnd()
      .split("\n");
    expect(rows.slice(1)).toEqual(["0.25,5,min/max of 500 ms"]);
  });
});
