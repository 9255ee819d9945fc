// What a surface's rest shape tells about each of its vertices.

import type { Surface } from "../protocol/types";

/** Rest positions of a surface's vertices, three numbers each. */
export function restPositions(surface: Surface, nodes: Float32Array, tets: Uint32Array): Float32Array {
  const out = new Float32Array(3 * surface.tets.length);
  for (let v = 0; v < surface.tets.length; v++) {
    for (let k = 0; k < 4; k++) {
      const node = tets[4 * surface.tets[v] + k];
      const w = surface.weights[4 * v + k];
      for (let c = 0; c < 3; c++) out[3 * v + c] += w * nodes[3 * node + c];
    }
  }
  return out;
}

/** Unit normals: of the triangles around a vertex, weighted by their angle there. Vertices that
 * lie at the same place count as one, so that seams do not show. */
export function vertexNormals(positions: Float32Array, triangles: Uint32Array): Float32Array {
  const count = positions.length / 3;
  const { same } = weld(positions);
  const sum = new Float64Array(3 * count);
  const p = (v: number, c: number) => positions[3 * v + c];
  for (let t = 0; t < triangles.length; t += 3) {
    for (let k = 0; k < 3; k++) {
      const [o, a, b] = [triangles[t + k], triangles[t + ((k + 1) % 3)], triangles[t + ((k + 2) % 3)]];
      const [ax, ay, az] = [p(a, 0) - p(o, 0), p(a, 1) - p(o, 1), p(a, 2) - p(o, 2)];
      const [bx, by, bz] = [p(b, 0) - p(o, 0), p(b, 1) - p(o, 1), p(b, 2) - p(o, 2)];
      const [nx, ny, nz] = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
      const length = Math.hypot(nx, ny, nz);
      if (length === 0) continue;
      const angle = Math.atan2(length, ax * bx + ay * by + az * bz) / length;
      sum[3 * same[o]] += angle * nx;
      sum[3 * same[o] + 1] += angle * ny;
      sum[3 * same[o] + 2] += angle * nz;
    }
  }
  const out = new Float32Array(3 * count);
  for (let v = 0; v < count; v++) {
    const s = 3 * same[v];
    const length = Math.hypot(sum[s], sum[s + 1], sum[s + 2]) || 1;
    for (let c = 0; c < 3; c++) out[3 * v + c] = sum[s + c] / length;
  }
  return out;
}

/** For each vertex the first one at the same place. */
export function weld(positions: Float32Array): { same: Uint32Array } {
  const count = positions.length / 3;
  const same = new Uint32Array(count);
  const first = new Map<string, number>();
  for (let v = 0; v < count; v++) {
    const key = `${positions[3 * v]},${positions[3 * v + 1]},${positions[3 * v + 2]}`;
    const found = first.get(key);
    if (found === undefined) first.set(key, v);
    same[v] = found ?? v;
  }
  return { same };
}

/** Area that belongs to each vertex, m²: a third of each triangle around it. */
export function vertexAreas(positions: Float32Array, triangles: Uint32Array): Float32Array {
  const out = new Float32Array(positions.length / 3);
  for (let t = 0; t < triangles.length; t += 3) {
    const [o, a, b] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const e = [0, 1, 2].map((c) => positions[a + c] - positions[o + c]);
    const f = [0, 1, 2].map((c) => positions[b + c] - positions[o + c]);
    const area =
      0.5 * Math.hypot(e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]);
    for (let k = 0; k < 3; k++) out[triangles[t + k]] += area / 3;
  }
  return out;
}

/** Neighbours along edges, one list after the other: those of v are `list[start[v]..start[v+1]]`. */
export interface Neighbours {
  readonly start: Uint32Array;
  readonly list: Uint32Array;
}

export function neighbours(positions: Float32Array, triangles: Uint32Array): Neighbours {
  const count = positions.length / 3;
  const { same } = weld(positions);
  const sets: Set<number>[] = Array.from({ length: count }, () => new Set());
  for (let t = 0; t < triangles.length; t += 3) {
    for (let k = 0; k < 3; k++) {
      const [a, b] = [triangles[t + k], triangles[t + ((k + 1) % 3)]];
      sets[same[a]].add(same[b]);
      sets[same[b]].add(same[a]);
    }
  }
  // Twins at one place see each other through the first of them.
  for (let v = 0; v < count; v++) {
    if (same[v] === v) continue;
    sets[same[v]].add(v);
    sets[v].add(same[v]);
  }
  const start = new Uint32Array(count + 1);
  for (let v = 0; v < count; v++) start[v + 1] = start[v] + sets[v].size;
  const list = new Uint32Array(start[count]);
  sets.forEach((set, v) => list.set([...set], start[v]));
  return { start, list };
}

/** Mean curvature, 1/m, from how normals turn along edges; positive where the surface is convex.
 * Smoothed a few times over neighbours. */
export function curvature(
  positions: Float32Array,
  normals: Float32Array,
  around: Neighbours,
  smoothings: number,
): Float32Array {
  const count = positions.length / 3;
  let values: Float32Array = new Float32Array(count);
  for (let v = 0; v < count; v++) {
    let sum = 0;
    let edgesSeen = 0;
    for (let i = around.start[v]; i < around.start[v + 1]; i++) {
      const w = around.list[i];
      let turn = 0;
      let square = 0;
      for (let c = 0; c < 3; c++) {
        const d = positions[3 * w + c] - positions[3 * v + c];
        turn += d * (normals[3 * w + c] - normals[3 * v + c]);
        square += d * d;
      }
      if (square === 0) continue;
      sum += turn / square;
      edgesSeen += 1;
    }
    values[v] = edgesSeen > 0 ? sum / edgesSeen : 0;
  }
  for (let s = 0; s < smoothings; s++) values = smoothed(values, around);
  return values;
}

function smoothed(values: Float32Array, around: Neighbours): Float32Array {
  return values.map((own, v) => {
    const [from, to] = [around.start[v], around.start[v + 1]];
    if (from === to) return own;
    let sum = 0;
    for (let i = from; i < to; i++) sum += values[around.list[i]];
    return 0.5 * own + (0.5 * sum) / (to - from);
  });
}
