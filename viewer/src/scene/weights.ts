// How much some bones together carry each vertex of the drawn skin (the paper's Fig. 3): 1 where the
// skinning target follows them alone, 0 where they have no say.

import type { HandModel, Skin, SoftModel } from "../protocol/types";

/** Which bone shows first: its weights fade at both of its ends. */
export const FIRST_BONES: readonly string[] = ["index-intermediate"];

/** Numbers of the hand's bones among the rigid bodies, by name; others do not count. */
export function bonesNamed(hand: HandModel, names: Iterable<string>): ReadonlySet<number> {
  const wanted = new Set(names);
  return new Set(hand.bones.flatMap(({ name }, b) => (wanted.has(name) ? [hand.bone_start + b] : [])));
}

/** Sum of the weights of `bones` at each vertex of the drawn surface: those of the nodes, by the
 * vertex's place in its tetrahedron. */
export function surfaceWeights(
  soft: SoftModel,
  skin: Skin,
  bones: ReadonlySet<number>,
  out: Float32Array,
): void {
  const nodes = new Float32Array(soft.nodes.length / 3);
  for (let i = 0; i < skin.weights.length; i++) if (bones.has(skin.bones[i])) nodes[i >> 1] += skin.weights[i];
  const { tets, weights } = soft.render;
  for (let v = 0; v < tets.length; v++) {
    let sum = 0;
    for (let k = 0; k < 4; k++) sum += weights[4 * v + k] * nodes[soft.tets[4 * tets[v] + k]];
    // A vertex a little outside of its tetrahedron would go beyond.
    out[v] = Math.min(1, Math.max(0, sum));
  }
}
