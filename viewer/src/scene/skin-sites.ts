// Where on a hand each vertex of its skin is: how much blood shows, how deep in a crease it lies,
// and where on a fingernail.

import type { HandModel, Skin, SoftModel } from "../protocol/types";
import { restPoses } from "./skinning";
import { curvature, neighbours } from "./surface";

/** Half width and half length of nails, m, and how far their middle lies before the tip joint. */
const NAIL = {
  thumb: { wide: 0.0064, long: 0.0068 },
  finger: { wide: 0.0046, long: 0.0054 },
} as const;

export interface SkinSites {
  /** Per vertex: blood 0 to 1, openness 0 (crease) to 1, place on the nail (beyond 1: none). */
  readonly site: Float32Array;
  /** Curvature of the skin, 1/m. */
  readonly curve: Float32Array;
}

export function skinSites(
  soft: SoftModel,
  skin: Skin,
  hand: HandModel,
  rest: Float32Array,
  normals: Float32Array,
): SkinSites {
  const surface = soft.render;
  const count = rest.length / 3;
  const around = neighbours(rest, surface.triangles);
  const curve = curvature(rest, normals, around, 4);
  const broad = curvature(rest, normals, around, 12);
  const poses = restPoses(soft, skin, hand);
  const site = new Float32Array(4 * count);
  const bound = new Float64Array(hand.bone_count);
  const scale = hand.length / 0.19;
  for (let v = 0; v < count; v++) {
    const b = boneOf(soft, skin, hand, v, bound);
    const bone = hand.bones[b];
    const p = inBone(poses, b, rest, v);
    // Bones run along -z, their backs look to +y.
    const half = 0.5 * Math.abs(bone.ends_B[0][2] - bone.ends_B[1][2]);
    const along = half > 0 ? -p[2] / half : 0;
    const distal = bone.name.endsWith("distal");
    const back = p[1] > 0;
    let blood = 0.22;
    if (distal) blood += 0.5 * smooth(-0.2, 1.2, along) * (back ? 0.6 : 1);
    if (bone.digit !== "palm" && back && !distal) blood += 0.35 * Math.exp(-(((along - 1) / 0.35) ** 2));
    if (bone.digit !== "palm" && back) blood += 0.3 * Math.exp(-(((along + 1) / 0.35) ** 2));
    if (!back) blood += 0.14;
    // Curvature as of a hand of 190 mm.
    const hollow = -broad[v] * scale;
    blood += 0.2 * smooth(0, 120, hollow);
    site[4 * v] = Math.min(1, blood);
    site[4 * v + 1] = 1 - 0.75 * smooth(20, 220, hollow);
    nailPlace(hand, b, poses, rest, v, scale, site);
  }
  return { site, curve };
}

/** Writes where a vertex lies on the plane of its digit's nail. Vertices off the nail are far from its
 * middle, in the direction in which they are: between two of them no triangle crosses the nail. */
function nailPlace(
  hand: HandModel,
  bone: number,
  poses: Float32Array,
  rest: Float32Array,
  v: number,
  scale: number,
  site: Float32Array,
): void {
  const { digit } = hand.bones[bone];
  const d = hand.bones.findIndex((other) => other.digit === digit && other.name.endsWith("distal"));
  let [u, w] = [0, -20];
  if (d >= 0) {
    const nail = digit === "thumb" ? NAIL.thumb : NAIL.finger;
    const [x, y, z] = inBone(poses, d, rest, v);
    const half = 0.5 * Math.abs(hand.bones[d].ends_B[0][2] - hand.bones[d].ends_B[1][2]);
    const off = y >= 0 ? 1 : 1 + Math.min(8, -y / (0.001 * scale));
    u = (off * x) / (nail.wide * scale);
    w = (off * (-z - (half - 0.25 * nail.long * scale))) / (nail.long * scale);
  }
  site[4 * v + 2] = u;
  site[4 * v + 3] = w;
}

/** A vertex in the frame of a bone, in the rest shape. */
function inBone(poses: Float32Array, bone: number, rest: Float32Array, v: number): [number, number, number] {
  const out: [number, number, number] = [0, 0, 0];
  const m = 12 * bone;
  for (let j = 0; j < 3; j++) {
    for (let i = 0; i < 3; i++) out[j] += poses[m + 3 * i + j] * (rest[3 * v + i] - poses[m + 9 + i]);
  }
  return out;
}

/** The bone that a vertex follows most, as an index in the hand's list. */
function boneOf(soft: SoftModel, skin: Skin, hand: HandModel, v: number, sum: Float64Array): number {
  sum.fill(0);
  for (let k = 0; k < 4; k++) {
    const node = soft.tets[4 * soft.render.tets[v] + k];
    for (let s = 0; s < 2; s++) {
      const bone = skin.bones[2 * node + s] - hand.bone_start;
      if (bone >= 0 && bone < sum.length)
        sum[bone] += soft.render.weights[4 * v + k] * skin.weights[2 * node + s];
    }
  }
  let best = 0;
  for (let b = 1; b < sum.length; b++) if (sum[b] > sum[best]) best = b;
  return best;
}

function smooth(from: number, to: number, x: number): number {
  const t = Math.min(1, Math.max(0, (x - from) / (to - from)));
  return t * t * (3 - 2 * t);
}
