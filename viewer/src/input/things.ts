// What there is to pick up in a scene, where it is, and where a hand would hold it.

import { Vector3 } from "three";
import type { HandModel, SceneModel, Snapshot } from "../protocol/types";
import { boneEnds, boneFrame, presentPose } from "./present-pose";

export interface Thing {
  readonly name: string;
  /** First and last of its nodes in a snapshot. */
  readonly soft: { readonly start: number; readonly end: number } | null;
  /** Index in `snapshot.rigids`. */
  readonly rigid: number | null;
}

export type Places = Pick<Snapshot, "nodes" | "rigids">;

/** What a hand can carry off: flesh of no hand, then rigid bodies that are free. */
export function thingsOf({ hands, softs, rigids }: SceneModel): Thing[] {
  if (hands.length === 0) return [];
  const flesh = softs.flatMap(({ name, hand, node_start: start, nodes }): Thing[] =>
    hand === null ? [{ name, soft: { start, end: start + nodes.length / 3 }, rigid: null }] : [],
  );
  const free = rigids.flatMap(({ name, kind, fixed }, rigid): Thing[] =>
    fixed || kind === "bone" || kind === "plane" || kind === "none" ? [] : [{ name, soft: null, rigid }],
  );
  return [...flesh, ...free];
}

/** Middle of a thing in the world frame, m; null where it has none. */
export function placeOf({ soft, rigid }: Thing, { nodes, rigids }: Places): Vector3 | null {
  const sum = new Vector3();
  if (rigid !== null) sum.fromArray(rigids, 7 * rigid);
  else if (soft !== null) {
    for (let n = soft.start; n < soft.end; n++) {
      sum.x += nodes[3 * n];
      sum.y += nodes[3 * n + 1];
      sum.z += nodes[3 * n + 2];
    }
    sum.divideScalar(soft.end - soft.start);
  }
  return (rigid === null && soft === null) || !sum.toArray().every(Number.isFinite) ? null : sum;
}

/** Middle of what a hand grips, from its wrist: towards the fingers, out of the palm and to the thumb's side, in
 * lengths of the hand. Means over the loaf, the car, the egg and the ball of the built-in scenes, each where the
 * scene's own script grips it: 0.102, 0.064 and 0.020 m, 0.188 m being the hand's length. */
const GRIPPED = { along: 0.54, below: 0.34, aside: 0.11 };

/** Where the hand would hold something, world frame, m; `tracked`: of the hand that leads, not of the simulated one. */
export function holdPoint(hand: HandModel, snapshot: Snapshot, tracked: boolean): Vector3 {
  const { position, rotation } = presentPose(hand, snapshot, tracked);
  const thumb = hand.side === "left" ? 1 : -1;
  const { along, below, aside } = GRIPPED;
  const from = new Vector3(thumb * aside, -below, -along).multiplyScalar(hand.length);
  return from.applyQuaternion(rotation).add(position);
}

/** Where the line down from a hand begins: on the vertical through its hold, as high as the end of a bone that is
 * nearest to that, world frame, m. */
export function aboveHold(hand: HandModel, snapshot: Snapshot): Vector3 {
  const hold = holdPoint(hand, snapshot, false);
  let [height, nearest] = [hold.y, Infinity];
  hand.bones.forEach((bone, b) => {
    for (const end of boneEnds(bone, boneFrame(hand, b, snapshot, false))) {
      const gap = Math.hypot(end.x - hold.x, end.z - hold.z);
      if (gap < nearest) [height, nearest] = [end.y, gap];
    }
  });
  return hold.setY(Math.max(hold.y, height));
}
