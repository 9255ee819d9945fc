// What there is to pick up in a scene, and whether the visitor has picked it up.

import { PER_DIGIT, PER_HAND, type SceneModel, type Snapshot } from "../protocol/types";

/** An object that rises this far above the lowest place of the visitor's lead counts as lifted, m. */
const RISE = 0.02;
/** The hand holds what it touches with at least this force, N: a twentieth of the loaf's weight. */
const HELD = 0.05;

export interface Thing {
  readonly name: string;
  /** First and last value of the heights to average, in `snapshot.nodes` or `snapshot.rigids`. */
  readonly soft: { readonly start: number; readonly end: number } | null;
  readonly rigid: number | null;
}

/** The first body that a hand can carry off: flesh of no hand, or a rigid body that is free. */
export function thingToLift({ hands, softs, rigids }: SceneModel): Thing | null {
  if (hands.length === 0) return null;
  const soft = softs.find((body) => body.hand === null);
  if (soft !== undefined) {
    const start = soft.node_start;
    return { name: soft.name, soft: { start, end: start + soft.nodes.length / 3 }, rigid: null };
  }
  const free = rigids.findIndex(({ kind, fixed }) => !fixed && kind !== "bone" && kind !== "plane" && kind !== "none");
  return free < 0 ? null : { name: rigids[free].name, soft: null, rigid: free };
}

/** Mean height of a thing in the world frame, m. */
export function heightOf({ soft, rigid }: Thing, { nodes, rigids }: Pick<Snapshot, "nodes" | "rigids">): number {
  if (rigid !== null) return rigids[7 * rigid + 1];
  if (soft === null) return NaN;
  let sum = 0;
  for (let n = soft.start; n < soft.end; n++) sum += nodes[3 * n + 1];
  return sum / (soft.end - soft.start);
}

/** Normal force on all digits of all hands, N. */
function pressing(fingers: Float32Array): number {
  let sum = 0;
  for (let at = 0; at + PER_HAND <= fingers.length; at += PER_HAND) {
    for (let digit = 0; digit < PER_HAND; digit += PER_DIGIT) sum += fingers[at + digit];
  }
  return sum;
}

/** Watches one lead of the visitor from its beginning. */
export class Lift {
  private lowest = Infinity;

  constructor(private readonly thing: Thing) {}

  /** True once the hand holds the thing above its lowest place so far. */
  seen(snapshot: Pick<Snapshot, "nodes" | "rigids" | "fingers">): boolean {
    const height = heightOf(this.thing, snapshot);
    if (!Number.isFinite(height)) return false;
    this.lowest = Math.min(this.lowest, height);
    return height - this.lowest > RISE && pressing(snapshot.fingers) > HELD;
  }
}
