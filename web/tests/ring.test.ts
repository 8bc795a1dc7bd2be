import { describe, expect, it } from "vitest";
import { copyWhere, decimate, display, niceRange, niceStep, widen } from "../src/model/decimate";
import { Ring } from "../src/model/ring";

function filled(rows: number, capacity: number): Ring {
  const ring = new Ring(capacity, 2);
  for (let row = 0; row < rows; row++) ring.push(Float64Array.of(row / 10, row), 1, 2);
  return ring;
}

describe("Ring", () => {
  it("keeps the newest rows in the order of their times", () => {
    const ring = filled(25, 10);
    expect([ring.first, ring.total, ring.length]).toEqual([15, 25, 10]);
    expect(ring.at(1, 15)).toBe(15);
    expect(ring.last_s).toBe(2.4);
    expect(ring.indexAt(1.95)).toBe(20);
    expect(ring.indexAt(99)).toBe(25);
    expect(ring.nearest(1, 1.96)).toBe(20);
    expect(ring.nearest(1, 1.94)).toBe(19);
  });

  it("leaves out columns that it has not, and fills those that did not come", () => {
    const ring = new Ring(4, 3);
    ring.push(Float64Array.of(1, 2, 3, 4, 5, 6, 7, 8), 2, 4);
    expect(ring.at(2, 1)).toBe(7);
    ring.push(Float64Array.of(9, 1), 1, 2);
    expect(ring.at(2, 2)).toBeNaN();
  });

  it("moves what is there back when the bench's clock begins anew", () => {
    const ring = filled(5, 10);
    ring.push(Float64Array.of(0.2, 99), 1, 2);
    const times = [];
    for (let index = ring.first; index < ring.total; index++) times.push(ring.at(0, index));
    expect([...times].sort((a, b) => a - b)).toEqual(times);
    expect(ring.at(1, ring.total - 1)).toBe(99);
    expect(ring.at(0, ring.first + 4)).toBeCloseTo(-0.8);
    expect(ring.movedBack_s).toBeCloseTo(1.2);
  });

  it("puts all of before a restart before what comes, whatever the new clock shows", () => {
    const ring = new Ring(10, 2);
    ring.push(Float64Array.of(1, 5, 2, 6), 2, 2);
    ring.restart();
    ring.push(Float64Array.of(9, 7), 1, 2);
    ring.push(Float64Array.of(9.5, 8), 1, 2);
    expect(Array.from({ length: ring.total }, (_, index) => ring.at(0, index))).toEqual([7, 8, 8, 9, 9.5]);
  });

  it("is copied as it is, and rearranged by column", () => {
    const ring = filled(12, 10);
    const copy = ring.copy();
    ring.push(Float64Array.of(9, 9), 1, 2);
    expect([copy.total, copy.at(1, 11)]).toEqual([12, 11]);
    const wider = copy.rearranged([0, -1, 1]);
    expect(wider.at(1, 11)).toBeNaN();
    expect(wider.at(2, 11)).toBe(11);
  });
});

describe("decimate", () => {
  it("gives rows as they are if they fit, with one more on each side", () => {
    const ring = filled(20, 50);
    const out = display(ring, 16);
    expect(decimate(ring, 0.5, 1.0, out)).toBe(7);
    expect([...out[1]!.slice(0, 7)]).toEqual([4, 5, 6, 7, 8, 9, 10]);
    expect(out[1]![15]).toBe(10);
  });

  it("keeps every extreme, in the order in which it came", () => {
    const ring = new Ring(4096, 2);
    for (let row = 0; row < 4000; row++) ring.push(Float64Array.of(row, row === 1234 ? 50 : row === 1235 ? -70 : -row / 1e6), 1, 2);
    const out = display(ring, 100);
    const made = decimate(ring, 0, 4000, out);
    expect(made).toBeLessThanOrEqual(100);
    const range: [number, number] = [Infinity, -Infinity];
    widen(out[1]!, made, range);
    expect(range).toEqual([-70, 50]);
    expect(out[1]!.indexOf(50)).toBeLessThan(out[1]!.indexOf(-70));
    for (let at = 1; at < made; at++) expect(out[0]![at]!).toBeGreaterThanOrEqual(out[0]![at - 1]!);
  });

  it("makes the same points of a bucket while the window moves", () => {
    const ring = new Ring(4096, 2);
    for (let row = 0; row < 4000; row++) ring.push(Float64Array.of(row, Math.sin(row)), 1, 2);
    const first = display(ring, 100);
    const second = display(ring, 100);
    decimate(ring, 0, 3000, first);
    decimate(ring, 7, 3007, second);
    expect(second[1]!.slice(20, 60)).toEqual(first[1]!.slice(20, 60));
  });

  it("is empty for an empty ring", () => {
    const ring = new Ring(8, 2);
    const out = display(ring, 4);
    expect(decimate(ring, 0, 1, out)).toBe(0);
    expect(out[1]![0]).toBeNaN();
  });
});

describe("ranges", () => {
  it("has whole steps and is never empty", () => {
    expect([0.03, 1, 3, 7, 26].map(niceStep)).toEqual([0.05, 1, 5, 10, 50]);
    const range = niceRange(3, 3, 1, [0, 0]);
    expect(range[1] - range[0]).toBeGreaterThanOrEqual(1);
    expect(niceRange(Infinity, -Infinity, 2, [0, 0])).toEqual([-1, 1]);
  });
});

describe("values that change their unit", () => {
  it("are parted by what stands beside them", () => {
    const ring = new Ring(10, 3);
    for (let row = 0; row < 8; row++) ring.push(Float64Array.of(row, 10 + row, row < 3 ? 120 : 118), 1, 3);
    const all = display(ring, 8);
    decimate(ring, 0, 8, all);
    const [angle, rpm] = [new Float64Array(8), new Float64Array(8)];
    copyWhere(all[1]!, all[2]!, (mode) => mode === 120, angle);
    copyWhere(all[1]!, all[2]!, (mode) => mode === 118, rpm);
    expect([...angle]).toEqual([10, 11, NaN, NaN, NaN, NaN, NaN, NaN]);
    expect([...rpm]).toEqual([NaN, NaN, NaN, NaN, 14, 15, 16, 17]);
  });
});
