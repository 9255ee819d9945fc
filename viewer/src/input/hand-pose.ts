// A pose of a hand by wrist and angles, and how it may move: towards a goal, no faster than a hand.

import { Quaternion, Vector3 } from "three";
import type { HandModel } from "../protocol/types";
import { clampAngles, restAngles, type Angles } from "./shapes";

/** m/s */
export const WRIST_SPEED_MOST = 1.5;
/** rad/s */
export const WRIST_TURN_MOST = 6;
/** rad/s */
export const ANGLE_SPEED_MOST = 7;
/** The wrist stays within this distance of the origin, m. */
export const REACH = 1;

export interface HandPose {
  /** Wrist in the world, m; -z towards the fingers, +y out of the back. */
  readonly position: Vector3;
  readonly rotation: Quaternion;
  angles: Angles;
}

export function restPose(hand: HandModel): HandPose {
  return { position: new Vector3(0, 0.15, 0), rotation: new Quaternion(), angles: restAngles(hand) };
}

export function copyPose(pose: HandPose): HandPose {
  return {
    position: pose.position.clone(),
    rotation: pose.rotation.clone(),
    angles: pose.angles.slice(),
  };
}

/** Keeps a goal where a hand can be. A number that is none falls back on `safe`. */
export function clampPose(goal: HandPose, hand: HandModel, safe: HandPose): void {
  const { position, rotation } = goal;
  if (![position.x, position.y, position.z].every(Number.isFinite)) position.copy(safe.position);
  position.clampLength(0, REACH);
  const length = rotation.length();
  if (Number.isFinite(length) && length > 1e-6) rotation.normalize();
  else rotation.copy(safe.rotation);
  goal.angles = clampAngles(goal.angles, hand);
}

/** Moves `pose` towards `goal` for `dt` seconds. */
export function follow(pose: HandPose, goal: HandPose, dt: number): void {
  const way = goal.position.clone().sub(pose.position);
  pose.position.add(way.clampLength(0, WRIST_SPEED_MOST * dt));
  pose.rotation.rotateTowards(goal.rotation, WRIST_TURN_MOST * dt).normalize();
  const most = ANGLE_SPEED_MOST * dt;
  pose.angles = pose.angles.map((angle, i) => {
    const left = goal.angles[i] - angle;
    return angle + Math.min(most, Math.max(-most, left));
  });
}

/** Position and quaternion as a pose message wants them. */
export function wristNumbers(pose: HandPose): number[] {
  const { position: p, rotation: q } = pose;
  return [p.x, p.y, p.z, q.x, q.y, q.z, q.w];
}
