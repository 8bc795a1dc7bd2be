import { describe, expect, it } from "vitest";
import { decoded, lineAt, partOf, pointsBetween, pointsOf, readDrawing, shareDone } from "../src/model/drawing";
import { PathDeviation } from "../src/model/path_deviation";
import { boardAngleOf, SampledPlaces } from "../src/model/sampled_places";

const ANSWER = {
  problems: [],
  remarks: ["p:2:1: too fast (slower)"],
  machine: "mill",
  figures: { lines: 5, duration_s: 3, feed_mm: 20, rapid_mm: 10, range: { x: [0, 10] } },
  axes: [
    { letter: "x", axis: "m1", unit: "mm", deg_per_unit: 9, zero_deg: 0 },
    { letter: "y", axis: "m2", unit: "mm", deg_per_unit: -9, zero_deg: 5 },
  ],
  path: {
    places: [0, 0, 10, 0, 10, 10, 0, 10, 0, 0],
    count: 5,
    rapids: [[1, 2]],
    lines: [
      [1, 2],
      [2, 3],
      [3, 5],
    ],
    is_whole: true,
  },
  runs: [
    { text: "{}", digest: "d1", duration_s: 1, timeline: [[0, 2]], pause_line: 2 },
    {
      text: "{}",
      digest: "d2",
      duration_s: 2,
      timeline: [
        [0, 3],
        [1.5, 5],
      ],
      pause_line: null,
    },
  ],
};

describe("a drawing", () => {
  const made = readDrawing(ANSWER);
  if (!made || "problems" in made) throw new Error("no drawing");

  it("is read", () => {
    expect(made.count).toBe(5);
    expect(made.remarks).toEqual([{ line: 2, column: 1, text: "too fast (slower)" }]);
    expect(made.figures.range).toEqual([["x", 0, 10]]);
    expect(made.text).toBeNull();
  });

  it("has problems instead", () => {
    expect(readDrawing({ problems: ["p:1:2: what (this)"], of: "machine" })).toEqual({
      of: "machine",
      problems: [{ line: 1, column: 2, text: "what (this)" }],
    });
  });

  it.each([null, 3, [], {}, { axes: [1] }, { axes: [{}], path: 3 }, "x"])("is none: %j", (raw) => {
    expect(readDrawing(raw)).toBeNull();
  });

  it("knows its runs by their digests, whatever their names are", () => {
    expect(["d1", "d2", "d3", ""].map((digest) => partOf({ digest }, made))).toEqual([0, 1, null, null]);
    const untold = readDrawing({ ...ANSWER, runs: ANSWER.runs.map(({ digest: _, ...run }) => run) });
    expect(untold && !("problems" in untold) && partOf({ digest: "" }, untold)).toBeNull();
  });

  it("tells the line and the share", () => {
    expect(lineAt(made.parts[1]!, 1.4)).toBe(3);
    expect(lineAt(made.parts[1]!, 1.6)).toBe(5);
    expect(shareDone(made.parts, 1, 0.5)).toBeCloseTo(0.5);
    expect(shareDone(made.parts, 0, 9)).toBe(1);
    expect(pointsOf(made, 3)).toEqual([1, 3]);
    expect(pointsOf(made, 99)).toEqual([0, 5]);
  });
});

/** A rapid of 20 mm, then a closed circle of 20 mm radius; a point each degree. */
function circle() {
  const places = [0, 0];
  for (let degree = 0; degree <= 360; degree++) places.push(20 * Math.cos((degree * Math.PI) / 180), 20 * Math.sin((degree * Math.PI) / 180));
  const count = places.length / 2;
  const runs = [
    {
      text: "{}",
      duration_s: 5.3,
      timeline: [
        [0, 2],
        [0.3, 4],
      ],
      pause_line: null,
    },
  ];
  const made = readDrawing({
    ...ANSWER,
    path: {
      places,
      count,
      rapids: [[1, 2]],
      lines: [
        [1, 2],
        [2, 4],
      ],
      is_whole: true,
    },
    runs,
  });
  if (!made || "problems" in made) throw new Error("no drawing");
  return made;
}

describe("a drawing that is seen late", () => {
  const made = circle();
  const on = (degree: number) => [20 * Math.cos((degree * Math.PI) / 180), 20 * Math.sin((degree * Math.PI) / 180)];

  it.each([
    ["in its rapid", 0.1, 0.1, [9, 0]],
    ["past its first corner, known to be in the rapid", 0.2, 0.32, on(1.2)],
    ["some way past it", 0.2, 0.9, on(43)],
    ["in the middle of the circle", 2.5, 2.6, on(165)],
    ["at the end", 5.29, 5.3, on(359.5)],
  ])("is compared with the path where it is: %s", (_, least_s, most_s, place) => {
    const off = new PathDeviation(made.places, 2, ...pointsBetween(made, made.parts[0], least_s, most_s));
    expect(off.take(place)).toBeLessThan(0.01);
  });

  it("would be 0.42 mm off by its beginning alone, 17 ms past the corner at 1500 mm/min", () => {
    expect(new PathDeviation(made.places, 2).take(on(1.2))).toBeCloseTo(0.42, 2);
  });

  it("does not take the beginning of a closed circle for its end", () => {
    const off = new PathDeviation(made.places, 2, ...pointsBetween(made, made.parts[0], 0.3, 0.31));
    for (let degree = 0; degree <= 360; degree += 2) expect(off.take(on(degree))).toBeLessThan(0.01);
  });
});

describe("places of samples", () => {
  const axes = [
    { deg_per_unit: 9, zero_deg: 0 },
    { deg_per_unit: 9, zero_deg: 18 },
  ];
  /** Largest deviation of a circle, with the shaft's zero of X moved by so much, and a following error. */
  function largest(zeroed_deg: number): number {
    const made = circle();
    const off = new PathDeviation(made.places, 2);
    const sampled = new SampledPlaces(axes);
    for (let at = 0; at <= 360; at++) {
      const [x, y] = [made.places[at * 2]! * 9, made.places[at * 2 + 1]! * 9 + 18];
      const error_deg = at ? 0.5 : 0;
      sampled.take(0, Float64Array.of(at * 0.005, x + error_deg - zeroed_deg, x), 1, 3);
      sampled.take(1, Float64Array.of(at * 0.005, y), 1, 2);
      while (sampled.next()) off.take(sampled.place);
    }
    return off.largest;
  }

  it("are by the boards' zeros: `hil zero` changes no deviation", () => {
    expect(largest(0)).toBeCloseTo(0.5 / 9, 2);
    expect(largest(287)).toBeCloseTo(largest(0), 9);
  });

  it("are of samples of one time", () => {
    const sampled = new SampledPlaces(axes);
    sampled.take(0, Float64Array.of(0.1, 9, 0.105, 18), 2, 2);
    expect(sampled.next()).toBe(false);
    sampled.take(1, Float64Array.of(0.105, 27), 1, 2);
    expect([sampled.next(), [...sampled.place], sampled.next()]).toEqual([true, [2, 1], false]);
    expect(boardAngleOf([{ name: "position_deg" }, { name: "yw" }])).toBe("yw");
    expect(boardAngleOf([{ name: "position_deg" }])).toBeUndefined();
  });
});

describe("a deviation", () => {
  const square = Float64Array.from(ANSWER.path.places);

  it("is the distance from the path, in its order", () => {
    const off = new PathDeviation(square, 2);
    expect(off.take([0, 0.5])).toBeCloseTo(0.5);
    for (let x = 1; x < 10; x++) expect(off.take([x, 0.1])).toBeCloseTo(0.1);
    for (let y = 1; y < 10; y++) expect(off.take([10.2, y])).toBeCloseTo(0.2);
    expect(off.largest).toBeCloseTo(0.5);
  });

  it("begins where the machine is", () => {
    const off = new PathDeviation(square, 2, 3, 5);
    expect(off.take([0, 7])).toBeCloseTo(0);
    expect(off.take([0, 6])).toBeCloseTo(0);
  });

  it("is 0 of no path", () => {
    expect(new PathDeviation(new Float64Array(2), 2).take([3, 4])).toBe(0);
  });
});

describe("bytes of a file", () => {
  const text = "G0 X1 (µ)";
  const utf16 = Uint8Array.from([0xff, 0xfe, ...[...text].flatMap((each) => [each.charCodeAt(0), 0])]);
  it.each([new TextEncoder().encode(text), utf16, Uint8Array.from([...text].map((each) => each.charCodeAt(0)))])("are its text", (bytes) => {
    expect(decoded(bytes)).toBe(text);
  });
});
