// Spheres that stand for bodies when asking how much of the surrounding light reaches a place.

import { Vector4 } from "three";
import type { SceneModel } from "../protocol/types";

/** Spheres of hands come first. */
export const HAND_SPHERES = 36;
export const SPHERES = 52;

/** Flesh around bones, m: at the start and at the end of a bone of that digit. */
const FLESH = { palm: [0.02, 0.022], thumb: [0.0125, 0.0095], finger: [0.0095, 0.0075] } as const;

interface OnBone {
  readonly rigid: number;
  readonly at: readonly [number, number, number];
  readonly radius: number;
}

interface OfNodes {
  readonly nodes: Uint32Array;
  readonly radius: number;
}

export class Occluders {
  readonly spheres = Array.from({ length: SPHERES }, () => new Vector4(0, -100, 0, 0));
  private readonly onBones: OnBone[] = [];
  private readonly onRigids: OnBone[] = [];
  private readonly ofNodes: OfNodes[] = [];

  setModel(model: SceneModel): void {
    this.onBones.length = this.onRigids.length = this.ofNodes.length = 0;
    for (const sphere of this.spheres) sphere.set(0, -100, 0, 0);
    for (const hand of model.hands) {
      hand.bones.forEach((bone, b) => {
        const [near, far] = FLESH[bone.digit === "palm" || bone.digit === "thumb" ? bone.digit : "finger"];
        const [from, to] = bone.ends_B;
        for (const [part, side] of bone.digit === "palm" ? PALM : SHAFT) {
          const at = [0, 1, 2].map((c) => from[c] + part * (to[c] - from[c]));
          const radius = near + part * (far - near);
          const rigid = hand.bone_start + b;
          this.onBones.push({ rigid, at: [at[0] + side, at[1], at[2]], radius });
        }
      });
    }
    this.onBones.length = Math.min(this.onBones.length, HAND_SPHERES);
    model.softs.forEach((soft) => {
      if (soft.hand === null) this.ofNodes.push(...clusters(soft.nodes, soft.node_start, 10));
    });
    model.rigids.forEach((rigid, r) => {
      if (rigid.fixed || rigid.mesh === null) return;
      for (const { nodes, radius } of clusters(rigid.mesh.positions, 0, 6)) {
        const at = mean(rigid.mesh.positions, nodes);
        this.onRigids.push({ rigid: r, at, radius });
      }
    });
  }

  update(rigids: Float32Array, nodes: Float32Array): void {
    this.onBones.forEach((sphere, i) => place(sphere, rigids, this.spheres[i]));
    let next = HAND_SPHERES;
    for (const sphere of this.onRigids) {
      if (next < SPHERES) place(sphere, rigids, this.spheres[next++]);
    }
    for (const { nodes: list, radius } of this.ofNodes) {
      if (next === SPHERES) break;
      let x = 0;
      let y = 0;
      let z = 0;
      for (let i = 0; i < list.length; i++) {
        x += nodes[3 * list[i]];
        y += nodes[3 * list[i] + 1];
        z += nodes[3 * list[i] + 2];
      }
      this.spheres[next++].set(x / list.length, y / list.length, z / list.length, radius);
    }
  }
}

/** Along the bone, and to the side, m. */
const SHAFT = [
  [0.15, 0],
  [0.85, 0],
] as const;
const PALM = [
  [0, 0],
  [0.35, 0.014],
  [0.35, -0.014],
  [0.8, 0.02],
  [0.8, -0.018],
] as const;

function place(sphere: OnBone, rigids: Float32Array, out: Vector4): void {
  const p = 7 * sphere.rigid;
  const [ox, oy, oz] = sphere.at;
  const x = rigids[p + 3];
  const y = rigids[p + 4];
  const z = rigids[p + 5];
  const w = rigids[p + 6];
  const tx = 2 * (y * oz - z * oy);
  const ty = 2 * (z * ox - x * oz);
  const tz = 2 * (x * oy - y * ox);
  out.set(
    rigids[p] + ox + w * tx + y * tz - z * ty,
    rigids[p + 1] + oy + w * ty + z * tx - x * tz,
    rigids[p + 2] + oz + w * tz + x * ty - y * tx,
    sphere.radius,
  );
}

function mean(positions: Float32Array, list: Uint32Array): [number, number, number] {
  const sum: [number, number, number] = [0, 0, 0];
  for (const i of list) for (let c = 0; c < 3; c++) sum[c] += positions[3 * i + c] / list.length;
  return sum;
}

/** Slices of a cloud of points along its longest side, at most `most`, each with a sphere's radius. */
function clusters(positions: Float32Array, start: number, most: number): OfNodes[] {
  const count = positions.length / 3;
  if (count === 0) return [];
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; i++) {
    low[i % 3] = Math.min(low[i % 3], positions[i]);
    high[i % 3] = Math.max(high[i % 3], positions[i]);
  }
  const size = [0, 1, 2].map((c) => high[c] - low[c]);
  const axis = size.indexOf(Math.max(...size));
  const thick = Math.sqrt(size[(axis + 1) % 3] * size[(axis + 2) % 3]);
  const slices = Math.max(1, Math.min(most, Math.round((1.5 * size[axis]) / Math.max(thick, 1e-6))));
  const lists: number[][] = Array.from({ length: slices }, () => []);
  for (let i = 0; i < count; i++) {
    const part = (positions[3 * i + axis] - low[axis]) / Math.max(size[axis], 1e-9);
    lists[Math.min(slices - 1, Math.floor(part * slices))].push(start + i);
  }
  return lists
    .filter((list) => list.length > 0)
    .map((list) => ({ nodes: Uint32Array.from(list), radius: 0.5 * thick }));
}
