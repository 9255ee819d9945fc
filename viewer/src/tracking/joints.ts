// One tracked hand at one instant, as a `joints` message carries it: 25 joints of WebXR Hand Input,
// eight numbers each (position m, quaternion x y z w, radius m). A joint's -z runs along its bone,
// away from the wrist; +y comes out of the back of the hand.

import { Quaternion, Vector3 } from "three";
import { JOINTS, JOINT_NUMBERS } from "../protocol/poses";

export { JOINTS, JOINT_NUMBERS };

/** 200 numbers. */
export type HandJoints = Float32Array;

const phalanges = (finger: string) =>
  ["metacarpal", "phalanx-proximal", "phalanx-intermediate", "phalanx-distal", "tip"].map(
    (part) => `${finger}-finger-${part}`,
  );

export const JOINT_NAMES: readonly string[] = [
  "wrist",
  "thumb-metacarpal",
  "thumb-phalanx-proximal",
  "thumb-phalanx-distal",
  "thumb-tip",
  ...phalanges("index"),
  ...phalanges("middle"),
  ...phalanges("ring"),
  ...phalanges("pinky"),
];

/** Per digit, thumb first: its joints from the base of the metacarpal to the tip. */
export const DIGIT_JOINTS: readonly (readonly number[])[] = [
  [1, 2, 3, 4],
  [5, 6, 7, 8, 9],
  [10, 11, 12, 13, 14],
  [15, 16, 17, 18, 19],
  [20, 21, 22, 23, 24],
];

export const THUMB_TIP = 4;
export const INDEX_TIP = 9;

export function newHandJoints(): HandJoints {
  return new Float32Array(JOINTS * JOINT_NUMBERS);
}

export function jointPosition(hand: HandJoints, joint: number, out = new Vector3()): Vector3 {
  return out.fromArray(hand, JOINT_NUMBERS * joint);
}

export function jointRotation(hand: HandJoints, joint: number, out = new Quaternion()): Quaternion {
  return out.fromArray(hand, JOINT_NUMBERS * joint + 3);
}

export function jointRadius(hand: HandJoints, joint: number): number {
  return hand[JOINT_NUMBERS * joint + 7];
}

export function jointDistance(hand: HandJoints, a: number, b: number): number {
  const [i, j] = [JOINT_NUMBERS * a, JOINT_NUMBERS * b];
  return Math.hypot(hand[i] - hand[j], hand[i + 1] - hand[j + 1], hand[i + 2] - hand[j + 2]);
}
