// Poses of the visitor's hands, as binary messages to the server (docs/protocol.md).

import { PROTOCOL_VERSION, type Side } from "./types";

export const POSE_KIND = { joints: 16, angles: 17, lost: 18 } as const;

/** Joints of WebXR Hand Input, numbers per joint: position 3, quaternion 4, radius. */
export const JOINTS = 25;
export const JOINT_NUMBERS = 8;
export const ANGLES = 20;

function message(kind: number, side: Side, number: number, clock: number, numbers: number): DataView {
  const view = new DataView(new ArrayBuffer(16 + 4 * numbers));
  view.setUint8(0, kind);
  view.setUint8(1, PROTOCOL_VERSION);
  view.setUint8(2, side === "left" ? 0 : 1);
  view.setUint32(4, number, true);
  view.setFloat64(8, clock, true);
  return view;
}

function fill(view: DataView, at: number, numbers: ArrayLike<number>): void {
  for (let i = 0; i < numbers.length; i++) view.setFloat32(at + 4 * i, numbers[i], true);
}

/** 25 joints × (position 3, quaternion 4, radius), world frame. `clock` in seconds. */
export function encodeJoints(
  side: Side,
  number: number,
  clock: number,
  joints: ArrayLike<number>,
): ArrayBuffer {
  if (joints.length !== JOINTS * JOINT_NUMBERS) throw new RangeError("25 joints of 8 numbers each");
  const view = message(POSE_KIND.joints, side, number, clock, joints.length);
  fill(view, 16, joints);
  return view.buffer as ArrayBuffer;
}

/** Wrist pose (7, world frame) and the 20 angles of `hands[].angles`, rad. */
export function encodeAngles(
  side: Side,
  number: number,
  clock: number,
  wrist: ArrayLike<number>,
  angles: ArrayLike<number>,
): ArrayBuffer {
  if (wrist.length !== 7 || angles.length !== ANGLES) throw new RangeError("7 and 20 numbers");
  const view = message(POSE_KIND.angles, side, number, clock, 7 + ANGLES);
  fill(view, 16, wrist);
  fill(view, 16 + 28, angles);
  return view.buffer as ArrayBuffer;
}

/** The hand is not tracked any more. */
export function encodeLost(side: Side, number: number, clock: number): ArrayBuffer {
  return message(POSE_KIND.lost, side, number, clock, 0).buffer as ArrayBuffer;
}
