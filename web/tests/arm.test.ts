import { expect, it } from "vitest";
import { ARM, armAt, type Pose } from "../src/model/arm";

const still: Pose = { hip: 0, upperarm: 0, forearm: 0, ellbow: 0, wrist: 0, hand: 0, gripper: 0 };
const near = (point: readonly number[], wanted: readonly number[]) => point.forEach((value, at) => void expect(value).toBeCloseTo(wanted[at]!, 9));

it("stands upright with its forearm ahead at 0", () => {
  const { points } = armAt(still);
  near(points[2], [0, 0, ARM.base + ARM.upperarm]);
  near(points[3], [ARM.forearm, 0, ARM.base + ARM.upperarm]);
  near(points[4], [ARM.forearm + ARM.hand, 0, ARM.base + ARM.upperarm]);
});

it("turns by its hip, and leans by its upper arm", () => {
  near(armAt({ ...still, hip: 90 }).points[3], [0, ARM.forearm, ARM.base + ARM.upperarm]);
  near(armAt({ ...still, upperarm: 90 }).points[2], [ARM.upperarm, 0, ARM.base]);
  near(armAt({ ...still, upperarm: 90, forearm: -90 }).points[3], [ARM.upperarm + ARM.forearm, 0, ARM.base]);
});

it("bends its wrist in the plane that the elbow turns", () => {
  const wrist = armAt(still).points[3];
  near(armAt({ ...still, wrist: 90 }).points[4], [wrist[0], wrist[1], wrist[2] - ARM.hand]);
  near(armAt({ ...still, wrist: 90, ellbow: 90 }).points[4], [wrist[0], wrist[1] + ARM.hand, wrist[2]]);
});

it("keeps its lengths in any pose, opens its gripper, and bears what is no number", () => {
  const { points, fingers } = armAt({ hip: 12, upperarm: -50, forearm: 20, ellbow: 77, wrist: -30, hand: 60, gripper: 75 });
  const far = (one: readonly number[], other: readonly number[]) => Math.hypot(...one.map((value, at) => value - other[at]!));
  expect(far(points[1], points[2])).toBeCloseTo(ARM.upperarm);
  expect(far(points[2], points[3])).toBeCloseTo(ARM.forearm);
  expect(far(points[3], points[4])).toBeCloseTo(ARM.hand);
  const closed = armAt(still).fingers;
  expect(far(...fingers)).toBeGreaterThan(4 * far(...closed));
  expect(armAt({ ...still, hip: NaN })).toEqual(armAt(still));
});
