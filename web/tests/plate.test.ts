import { expect, it } from "vitest";
import { placeOf, plateAxis } from "../src/model/plate";

const axis = (letter: string, of: string, unit = "mm") => ({ letter, axis: of, unit, deg_per_unit: -72, zero_deg: 90, range: [0, 120] as [number, number] });
const machine = [axis("x", "m1"), axis("y", "m2"), axis("c", "m3", "deg")];

it("is as large as the machine of the bench's drawing, in its scale", () => {
  const x = plateAxis("x", "", null, machine, "s1");
  expect(x).toEqual({ name: "m1", deg_per_mm: -72, zero_deg: 90, range_mm: [0, 120] });
  expect(placeOf(x, 18)).toBe(1);
  expect(plateAxis("x", "m2", null, machine).range_mm).toEqual([0, 120]);
});

it("goes by millimetres a turn where these are chosen, or no machine has the axis", () => {
  expect(plateAxis("x", "", 5, machine)).toEqual({ name: "m1", deg_per_mm: 72, zero_deg: 0, range_mm: null });
  expect(plateAxis("x", "s9", null, machine)).toMatchObject({ name: "s9", deg_per_mm: 9, range_mm: null });
  expect(plateAxis("y", "", null, [], "s2")).toMatchObject({ name: "s2", deg_per_mm: 9 });
  expect(plateAxis("x", "m3", null, machine)).toMatchObject({ name: "m3", range_mm: null });
});
