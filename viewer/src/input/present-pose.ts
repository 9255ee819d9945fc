// The pose a hand has now, from a snapshot: where the tracker put its bones, or, where nothing is
// tracked, where the bones are. Angles come from the joints' frames in the model.

import { Quaternion, Vector3 } from "three";
import type { HandBone, HandModel, Snapshot } from "../protocol/types";
import type { HandPose } from "./hand-pose";
import { clampAngles, restAngles, type Angles } from "./shapes";

interface Frame {
  readonly position: Vector3;
  readonly rotation: Quaternion;
}

function frameAt(numbers: ArrayLike<number>, at: number): Frame {
  const [x, y, z, qx, qy, qz, qw] = Array.from({ length: 7 }, (_, i) => numbers[at + i]);
  return { position: new Vector3(x, y, z), rotation: new Quaternion(qx, qy, qz, qw) };
}

/** World frame of bone `b` as tracked, else as simulated. */
export function boneFrame(hand: HandModel, b: number, snapshot: Snapshot, tracked: boolean): Frame {
  const at = 7 * (hand.target_start + b);
  if (tracked && Number.isFinite(snapshot.targets[at])) return frameAt(snapshot.targets, at);
  return frameAt(snapshot.rigids, 7 * (hand.bone_start + b));
}

/** Both ends of a bone in the world, m. */
export function boneEnds(bone: HandBone, frame: Frame): [Vector3, Vector3] {
  const end = (k: 0 | 1) =>
    new Vector3(...bone.ends_B[k]).applyQuaternion(frame.rotation).add(frame.position);
  return [end(0), end(1)];
}

/** `tracked`: of the hand that leads; else of the simulated one. */
export function presentPose(hand: HandModel, snapshot: Snapshot, tracked = true): HandPose {
  const palm = boneFrame(hand, 0, snapshot, tracked);
  const wrist_B = frameAt(hand.wrist_B, 0);
  const position = wrist_B.position.applyQuaternion(palm.rotation).add(palm.position);
  const rotation = palm.rotation.clone().multiply(wrist_B.rotation).normalize();
  return { position, rotation, angles: presentAngles(hand, snapshot) };
}

function presentAngles(hand: HandModel, snapshot: Snapshot): Angles {
  const angles = restAngles(hand);
  hand.angles.forEach((angle, k) => {
    const parent = angle === null ? null : hand.bones[angle.bone].parent;
    if (angle === null || parent === null) return;
    const before = boneFrame(hand, parent, snapshot, true).rotation.clone();
    before.multiply(new Quaternion(...angle.rotation_PJ));
    const turn = before.invert().multiply(boneFrame(hand, angle.bone, snapshot, true).rotation);
    turn.multiply(new Quaternion(...angle.rotation_BK)).normalize();
    const twoAxes = hand.angles.some((other) => other?.bone === angle.bone && other.axis === "y");
    const [about_y, about_x] = twoAxes ? universal(turn) : [0, 2 * Math.atan2(turn.x, turn.w)];
    angles[k] = angle.sense * wrap(angle.axis === "x" ? about_x : about_y);
  });
  return clampAngles(angles, hand);
}

/** The turns about y, then x, that come nearest to a rotation. */
function universal({ x, y, z, w }: Quaternion): [number, number] {
  const sum = Math.atan2(x + y, w + z);
  const difference = Math.atan2(y - x, w - z);
  return [sum + difference, sum - difference];
}

function wrap(angle: number): number {
  return angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
}
