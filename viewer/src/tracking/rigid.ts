// Rigid motions between frames: `a_from_b` takes points of frame b to frame a.

import { Quaternion, Vector3 } from "three";
import { JOINTS, JOINT_NUMBERS, type HandJoints } from "./joints";

export interface Rigid {
  readonly position: Vector3;
  readonly rotation: Quaternion;
}

export function identity(): Rigid {
  return { position: new Vector3(), rotation: new Quaternion() };
}

export function inverse(motion: Rigid): Rigid {
  const rotation = motion.rotation.clone().conjugate();
  return { position: motion.position.clone().applyQuaternion(rotation).negate(), rotation };
}

const position = new Vector3();
const rotation = new Quaternion();

/** Carries all joints over, in place; radii stay. */
export function moveJoints(hand: HandJoints, motion: Rigid): void {
  for (let joint = 0; joint < JOINTS; joint++) {
    const at = JOINT_NUMBERS * joint;
    position.fromArray(hand, at).applyQuaternion(motion.rotation).add(motion.position).toArray(hand, at);
    rotation
      .fromArray(hand, at + 3)
      .premultiply(motion.rotation)
      .normalize()
      .toArray(hand, at + 3);
  }
}
