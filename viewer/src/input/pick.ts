// Which hand is under the pointer: bones as capsules, thick as fingers.

import { Ray, Vector3 } from "three";
import type { SceneModel, Snapshot } from "../protocol/types";
import { boneEnds, boneFrame } from "./present-pose";

/** A bone is picked within this many of its radii, or this far, m: its flesh counts. */
const RADII = 2.4;
const THICKNESS = 0.012;
const PALM_THICKNESS = 0.035;

export interface Picked {
  readonly hand: number;
  readonly bone: number;
  /** Nearest point of the bone's axis, m. */
  readonly point: Vector3;
  /** Along the ray, m. */
  readonly distance: number;
}

/** The nearest hand's bone on a ray given in the world frame of the simulation. */
export function pickHand(ray: Ray, model: SceneModel, snapshot: Snapshot): Picked | null {
  let best: Picked | null = null;
  model.hands.forEach((hand, h) => {
    hand.bones.forEach((bone, b) => {
      const [from, to] = boneEnds(bone, boneFrame(hand, b, snapshot, false));
      const onRay = new Vector3();
      const onBone = new Vector3();
      const gap = Math.sqrt(ray.distanceSqToSegment(from, to, onRay, onBone));
      const reach = bone.digit === "palm" ? PALM_THICKNESS : Math.max(THICKNESS, RADII * bone.radius);
      if (!(gap <= reach)) return;
      const distance = onRay.distanceTo(ray.origin);
      if (best === null || distance < best.distance) best = { hand: h, bone: b, point: onBone, distance };
    });
  });
  return best;
}
