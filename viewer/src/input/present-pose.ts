// The pose a hand has now, from a snapshot: where the tracker put its bones, or, where nothing is
// tracked, where the bones are. Angles come from the directions of the bones: exact for hinges,
// within a few degrees for the bases, whose zero the model does not carry. The server blends into
// a new input, so that is near enough.

import { Quaternion, Vector3 } from "three";
import { DIGITS, type HandBone, type HandModel, type Snapshot } from "../protocol/types";
import type { HandPose } from "./hand-pose";
import { clampAngles, restAngles } from "./shapes";

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

export function presentPose(hand: HandModel, snapshot: Snapshot): HandPose {
  const palm = boneFrame(hand, 0, snapshot, true);
  const wrist_B = frameAt(hand.wrist_B, 0);
  const position = wrist_B.position.applyQuaternion(palm.rotation).add(palm.position);
  const rotation = palm.rotation.clone().multiply(wrist_B.rotation).normalize();
  return { position, rotation, angles: presentAngles(hand, snapshot, rotation) };
}

function presentAngles(hand: HandModel, snapshot: Snapshot, wrist: Quaternion) {
  const angles = restAngles(hand);
  const toWrist = wrist.clone().invert();
  DIGITS.slice(1).forEach((digit, d) => {
    // Directions of the digit's bones, from the palm outwards, seen from the wrist.
    const along = hand.bones
      .map((bone, b) => ({ bone, b }))
      .filter(({ bone }) => bone.digit === digit)
      .map(({ bone, b }) => {
        const [from, to] = boneEnds(bone, boneFrame(hand, b, snapshot, true));
        return to.sub(from).normalize().applyQuaternion(toWrist);
      });
    if (along.length !== 3) return;
    // The thumb's base is counted from its own rest, which cannot be seen: it stays at rest.
    if (d > 0) {
      angles[4 * d] = Math.atan2(-along[0].y, -along[0].z);
      angles[4 * d + 1] = spread(along[0], hand, d);
    }
    angles[4 * d + 2] = along[0].angleTo(along[1]) * bendSign(along[0], along[1], d);
    angles[4 * d + 3] = along[1].angleTo(along[2]) * bendSign(along[1], along[2], d);
  });
  return clampAngles(angles, hand);
}

/** Away from the middle finger is positive; x points to the thumb on a left hand. */
function spread(along: Vector3, hand: HandModel, d: number): number {
  const flat = Math.hypot(along.y, along.z);
  const toThumb = Math.atan2(along.x, flat) * (hand.side === "left" ? 1 : -1);
  return d <= 2 ? toThumb : -toThumb;
}

/** Fingers close about -x of the wrist. The thumb hardly bends backwards: its bends count as
 * closing. */
function bendSign(from: Vector3, to: Vector3, d: number): number {
  return d === 0 || from.clone().cross(to).x <= 0 ? 1 : -1;
}
