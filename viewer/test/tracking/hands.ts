// Hands to test with: those that IWER stores (MIT, measured on a headset), and a made-up one.

import { pinchHandPose } from "iwer/lib/device/configs/hand/pinch.js";
import { pointHandPose } from "iwer/lib/device/configs/hand/point.js";
import { relaxedHandPose } from "iwer/lib/device/configs/hand/relaxed.js";
import type { Side } from "../../src/protocol/types";
import { JOINT_NAMES, JOINT_NUMBERS, newHandJoints, type HandJoints } from "../../src/tracking/joints";

export const STORED_POSES = ["relaxed", "pinch", "point"] as const;
export type StoredPose = (typeof STORED_POSES)[number];

interface Stored {
  readonly jointTransforms: Readonly<
    Record<string, { readonly offsetMatrix: ArrayLike<number>; readonly radius: number }>
  >;
}
const POSES: Readonly<Record<StoredPose, Stored>> = {
  relaxed: relaxedHandPose,
  pinch: pinchHandPose,
  point: pointHandPose,
};

/** Signs that mirror IWER's left hand into a right one. */
const MIRROR = [1, -1, -1, 0, -1, 1, 1, 0, -1, 1, 1, 0, -1, 1, 1, 1];

/** As WebXR fills them: 16 numbers per joint, column-major, and a radius each. */
export function storedHand(side: Side, pose: StoredPose): { matrices: Float32Array; radii: Float32Array } {
  const matrices = new Float32Array(16 * JOINT_NAMES.length);
  const radii = new Float32Array(JOINT_NAMES.length);
  JOINT_NAMES.forEach((name, i) => {
    const { offsetMatrix, radius } = POSES[pose].jointTransforms[name];
    for (let k = 0; k < 16; k++) {
      matrices[16 * i + k] = offsetMatrix[k] * (side === "right" ? MIRROR[k] : 1);
    }
    radii[i] = radius;
  });
  return { matrices, radii };
}

/** Fingers along -z; `chains` from wrist to tip of each digit, `radius` everywhere, m. */
export function straightHand(chains: readonly number[], radius: number): HandJoints {
  const hand = newHandJoints();
  const put = (joint: number, x: number, z: number) =>
    hand.set([x, 0, z, 0, 0, 0, 1, radius], JOINT_NUMBERS * joint);
  put(0, 0, 0);
  let joint = 1;
  chains.forEach((chain, digit) => {
    // The first joint of a digit lies aside: it must not count.
    const count = digit === 0 ? 4 : 5;
    put(joint, 0.01, -0.01);
    for (let k = 1; k < count; k++) put(joint + k, 0, (-chain * k) / (count - 1));
    joint += count;
  });
  return hand;
}
