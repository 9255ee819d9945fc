// Gesture that brings the scene before the visitor again: the left hand pinches, away from the scene
// and touching nothing, and is held still for two seconds.

import { Vector3 } from "three";
import { INDEX_TIP, THUMB_TIP, jointDistance, jointPosition, type HandJoints } from "../tracking/joints";

/** s */
export const HOLD_S = 2;
/** Thumb to index tip, m. */
const PINCH = 0.022;
/** The wrist may wander this far, m. */
const STILL = 0.06;
/** From the middle of the scene to the wrist, along the ground, m. */
const AWAY = 0.3;

export class RecentreGesture {
  private since: number | null = null;
  private readonly from = new Vector3();
  private readonly wrist = new Vector3();
  private done = false;

  /** How far the hold has come, 0 to 1. */
  progress = 0;

  /** `left`: the left hand in the world frame, or null; `touching`: it presses on something.
   * True once per hold, in the frame that completes it. */
  update(left: HandJoints | null, centre: Vector3, touching: boolean, time: number): boolean {
    if (left === null || touching || !this.holds(left, centre)) {
      this.since = null;
      this.done = false;
      this.progress = 0;
      return false;
    }
    if (this.since === null || this.wrist.distanceTo(this.from) > STILL) {
      this.since = time;
      this.from.copy(this.wrist);
    }
    this.progress = this.done ? 0 : Math.min(1, (time - this.since) / HOLD_S);
    if (this.done || this.progress < 1) return false;
    this.done = true;
    this.progress = 0;
    return true;
  }

  private holds(left: HandJoints, centre: Vector3): boolean {
    jointPosition(left, 0, this.wrist);
    const away = Math.hypot(this.wrist.x - centre.x, this.wrist.z - centre.z);
    return away > AWAY && jointDistance(left, THUMB_TIP, INDEX_TIP) < PINCH;
  }
}
