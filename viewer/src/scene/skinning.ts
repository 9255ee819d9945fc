// Skinning targets of a hand's nodes (Eq. 6): where the nodes would be if they followed the bones
// and nothing else.

import type { HandModel, Skin, SoftModel } from "../protocol/types";

/** Pose of each of a hand's bones in the flesh's rest shape, seven numbers per bone: the rigid motion
 * that takes the skin's offsets to the nodes they belong to. */
export function restPoses(soft: SoftModel, skin: Skin, hand: HandModel): Float32Array {
  const out = new Float32Array(12 * hand.bone_count);
  for (let b = 0; b < hand.bone_count; b++) out.set(restPose(soft, skin, hand.bone_start + b), 12 * b);
  return out;
}

/** Least squares over the nodes that hang on one bone alone: x = M o + t, row-major M then t. */
function restPose(soft: SoftModel, skin: Skin, bone: number): Float64Array {
  const pairs: [number, number][] = [];
  const nodeCount = soft.nodes.length / 3;
  for (const least of [0.999, 0.7, 0.3, 1e-6]) {
    pairs.length = 0;
    for (let n = 0; n < nodeCount; n++) {
      for (let k = 0; k < 2; k++) {
        if (skin.bones[2 * n + k] === bone && skin.weights[2 * n + k] >= least) pairs.push([n, k]);
      }
    }
    if (pairs.length >= 8) break;
  }
  const out = new Float64Array(12);
  out[0] = out[4] = out[8] = 1;
  if (pairs.length < 4) return out;
  const x = (n: number, c: number) => soft.nodes[3 * n + c];
  const o = (n: number, k: number, c: number) => skin.offsets[6 * n + 3 * k + c];
  const [meanX, meanO] = [
    [0, 0, 0],
    [0, 0, 0],
  ];
  for (const [n, k] of pairs) {
    for (let c = 0; c < 3; c++) {
      meanX[c] += x(n, c) / pairs.length;
      meanO[c] += o(n, k, c) / pairs.length;
    }
  }
  const A = new Float64Array(9);
  const B = new Float64Array(9);
  for (const [n, k] of pairs) {
    for (let i = 0; i < 3; i++) {
      for (let j = 0; j < 3; j++) {
        A[3 * i + j] += (x(n, i) - meanX[i]) * (o(n, k, j) - meanO[j]);
        B[3 * i + j] += (o(n, k, i) - meanO[i]) * (o(n, k, j) - meanO[j]);
      }
    }
  }
  const inverse = inverse3(B);
  if (inverse === null) return out;
  for (let i = 0; i < 3; i++) {
    for (let j = 0; j < 3; j++) {
      out[3 * i + j] = A[3 * i] * inverse[j] + A[3 * i + 1] * inverse[3 + j] + A[3 * i + 2] * inverse[6 + j];
    }
  }
  for (let i = 0; i < 3; i++) {
    out[9 + i] = meanX[i] - out[3 * i] * meanO[0] - out[3 * i + 1] * meanO[1] - out[3 * i + 2] * meanO[2];
  }
  return out;
}

function inverse3(m: Float64Array): Float64Array | null {
  const c = [
    m[4] * m[8] - m[5] * m[7],
    m[2] * m[7] - m[1] * m[8],
    m[1] * m[5] - m[2] * m[4],
    m[5] * m[6] - m[3] * m[8],
    m[0] * m[8] - m[2] * m[6],
    m[2] * m[3] - m[0] * m[5],
    m[3] * m[7] - m[4] * m[6],
    m[1] * m[6] - m[0] * m[7],
    m[0] * m[4] - m[1] * m[3],
  ];
  const det = m[0] * c[0] + m[1] * c[3] + m[2] * c[6];
  const size = Math.max(...m.map(Math.abs));
  if (Math.abs(det) < 1e-12 * size ** 3) return null;
  return Float64Array.from(c, (v) => v / det);
}

/** Nodes bound to no bone take the binding of the nearest one that is; a copy of the skin. */
export function completeSkin(soft: SoftModel, skin: Skin, hand: HandModel, rest: Float32Array): Skin {
  const count = soft.nodes.length / 3;
  const bound = (n: number) => skin.weights[2 * n] + skin.weights[2 * n + 1] > 0;
  const bones = skin.bones.slice();
  const weights = skin.weights.slice();
  const offsets = skin.offsets.slice();
  for (let n = 0; n < count; n++) {
    if (bound(n)) continue;
    let nearest = -1;
    let least = Infinity;
    for (let m = 0; m < count; m++) {
      if (!bound(m)) continue;
      let square = 0;
      for (let c = 0; c < 3; c++) square += (soft.nodes[3 * m + c] - soft.nodes[3 * n + c]) ** 2;
      if (square < least) [least, nearest] = [square, m];
    }
    if (nearest < 0) continue;
    for (let k = 0; k < 2; k++) {
      const bone = skin.bones[2 * nearest + k];
      bones[2 * n + k] = bone;
      weights[2 * n + k] = skin.weights[2 * nearest + k];
      const r = 12 * (bone - hand.bone_start);
      if (r < 0 || r + 12 > rest.length) continue;
      // The offset in the bone's frame, by the transposed rotation.
      for (let j = 0; j < 3; j++) {
        let sum = 0;
        for (let i = 0; i < 3; i++) sum += rest[r + 3 * i + j] * (soft.nodes[3 * n + i] - rest[r + 9 + i]);
        offsets[6 * n + 3 * k + j] = sum;
      }
    }
  }
  return { bones, weights, offsets };
}

/** Targets of all nodes for bones at `poses` (seven numbers each); `first` is the rigid whose pose
 * comes first. False if a pose is not known. */
export function skinNodes(skin: Skin, poses: Float32Array, first: number, out: Float32Array): boolean {
  for (let n = 0; n < out.length / 3; n++) {
    let sx = 0;
    let sy = 0;
    let sz = 0;
    for (let k = 0; k < 2; k++) {
      const weight = skin.weights[2 * n + k];
      if (weight === 0) continue;
      const at = 7 * (skin.bones[2 * n + k] - first);
      const ox = skin.offsets[6 * n + 3 * k];
      const oy = skin.offsets[6 * n + 3 * k + 1];
      const oz = skin.offsets[6 * n + 3 * k + 2];
      const x = poses[at + 3];
      const y = poses[at + 4];
      const z = poses[at + 5];
      const w = poses[at + 6];
      // o + 2 w (q × o) + 2 q × (q × o)
      const tx = 2 * (y * oz - z * oy);
      const ty = 2 * (z * ox - x * oz);
      const tz = 2 * (x * oy - y * ox);
      sx += weight * (poses[at] + ox + w * tx + y * tz - z * ty);
      sy += weight * (poses[at + 1] + oy + w * ty + z * tx - x * tz);
      sz += weight * (poses[at + 2] + oz + w * tz + x * ty - y * tx);
    }
    out[3 * n] = sx;
    out[3 * n + 1] = sy;
    out[3 * n + 2] = sz;
  }
  return Number.isFinite(out[0]);
}
