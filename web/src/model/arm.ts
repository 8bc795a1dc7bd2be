/** Walter's arm in space: where its joints are at given angles. Pure.
 *
 * The controller knows angles alone. The lengths here are near those of the arm, and only make a picture. */

export const JOINTS = ["hip", "upperarm", "forearm", "ellbow", "wrist", "hand", "gripper"] as const;
export type Joint = (typeof JOINTS)[number];
export type Pose = Readonly<Record<Joint, number>>;
export type Point = [number, number, number];

/** In units of the picture; the arm is 1 high when it stands. */
export const ARM = { base: 0.22, upperarm: 0.3, forearm: 0.3, hand: 0.18, finger: 0.07 };

/** Angle at 0 of the forearm: it lies ahead. */
const FOREARM_AT_0_DEG = 90;
const MOST_OPEN_DEG = 75;

export interface ArmShape {
  /** Foot, shoulder, elbow, wrist and tip; z is up. */
  points: [Point, Point, Point, Point, Point];
  /** Tips of both fingers. */
  fingers: [Point, Point];
}

export function armAt(pose: Pose): ArmShape {
  const yaw = rad(pose.hip);
  const ahead: Point = [Math.cos(yaw), Math.sin(yaw), 0];
  const side: Point = [-Math.sin(yaw), Math.cos(yaw), 0];
  const up: Point = [0, 0, 1];
  const shoulder: Point = [0, 0, ARM.base];
  const upper = tilted(ahead, up, rad(pose.upperarm));
  const elbow = plus(shoulder, upper, ARM.upperarm);
  const foreAngle = rad(pose.upperarm + pose.forearm + FOREARM_AT_0_DEG);
  const fore = tilted(ahead, up, foreAngle);
  const wrist = plus(elbow, fore, ARM.forearm);
  // The elbow turns the wrist's axis about the forearm.
  const roll = rad(pose.ellbow);
  const across = tilted(ahead, up, foreAngle + Math.PI / 2);
  const bend = sum(across, Math.cos(roll), side, Math.sin(roll));
  const hand = sum(fore, Math.cos(rad(pose.wrist)), bend, Math.sin(rad(pose.wrist)));
  const tip = plus(wrist, hand, ARM.hand);
  const beside = cross(hand, bend);
  const turn = rad(pose.hand);
  const wide = sum(unit(beside), Math.cos(turn), unit(cross(hand, beside)), Math.sin(turn));
  const open = 0.012 + 0.045 * Math.min(Math.max(pose.gripper / MOST_OPEN_DEG, 0), 1);
  const finger = (by: number): Point => plus(plus(tip, hand, ARM.finger), wide, by);
  return { points: [[0, 0, 0], shoulder, elbow, wrist, tip], fingers: [finger(open), finger(-open)] };
}

/** Direction that is so far from upright, ahead. */
function tilted(ahead: Point, up: Point, angle: number): Point {
  return sum(up, Math.cos(angle), ahead, Math.sin(angle));
}

function rad(deg: number): number {
  return Number.isFinite(deg) ? (deg * Math.PI) / 180 : 0;
}

function plus(from: Point, along: Point, length: number): Point {
  return [from[0] + along[0] * length, from[1] + along[1] * length, from[2] + along[2] * length];
}

function sum(one: Point, a: number, other: Point, b: number): Point {
  return [one[0] * a + other[0] * b, one[1] * a + other[1] * b, one[2] * a + other[2] * b];
}

function cross(one: Point, other: Point): Point {
  return [one[1] * other[2] - one[2] * other[1], one[2] * other[0] - one[0] * other[2], one[0] * other[1] - one[1] * other[0]];
}

function unit(of: Point): Point {
  const length = Math.hypot(...of) || 1;
  return [of[0] / length, of[1] / length, of[2] / length];
}
