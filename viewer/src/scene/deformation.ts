// How a tetrahedral body is deformed, as a texture that vertex shaders read: per node its position,
// and the cofactor of the deformation gradient averaged over the tetrahedra around it. The cofactor
// turns areas, and so normals; averaged, it makes shading smooth where the embedding only bends
// from one tetrahedron to the next.

import { DataTexture, FloatType, NearestFilter, RGBAFormat } from "three";

/** Nodes per row of the texture, four texels each. */
export const NODES_PER_ROW = 256;
const FLOATS = 16;

export class Deformation {
  readonly texture: DataTexture;
  /** Sixteen numbers per node: position and 0, then the columns of the cofactor, each and 0. */
  readonly data: Float32Array;
  readonly nodeCount: number;
  /** Per tetrahedron: the transposed rest edges over 6, so that a cofactor comes out times volume. */
  private readonly restEdges: Float32Array;
  /** One over the volume around each node, 1/m³. */
  private readonly perVolume: Float32Array;

  constructor(
    rest: Float32Array,
    private readonly tets: Uint32Array,
  ) {
    this.nodeCount = rest.length / 3;
    const rows = Math.max(1, Math.ceil(this.nodeCount / NODES_PER_ROW));
    this.data = new Float32Array(FLOATS * NODES_PER_ROW * rows);
    this.texture = new DataTexture(this.data, 4 * NODES_PER_ROW, rows, RGBAFormat, FloatType);
    this.texture.minFilter = NearestFilter;
    this.texture.magFilter = NearestFilter;

    const count = tets.length / 4;
    this.restEdges = new Float32Array(9 * count);
    const volume = new Float64Array(this.nodeCount);
    const e = new Float64Array(9);
    for (let t = 0; t < count; t++) {
      edges(rest, 0, tets, t, e);
      for (let row = 0; row < 3; row++) {
        for (let column = 0; column < 3; column++) {
          // Row-major transpose of the matrix whose columns are the edges: its rows are the edges.
          this.restEdges[9 * t + 3 * row + column] = e[3 * row + column] / 6;
        }
      }
      const v = Math.abs(determinant(e)) / 6;
      for (let k = 0; k < 4; k++) volume[tets[4 * t + k]] += v;
    }
    this.perVolume = Float32Array.from(volume, (v) => (v > 0 ? 1 / v : 0));
    this.update(rest, 0);
  }

  /** Takes the nodes' present positions, starting at node `start` of `positions`. */
  update(positions: Float32Array, start: number): void {
    const { data, tets, restEdges, perVolume, nodeCount } = this;
    for (let i = 0; i < nodeCount; i++) {
      const to = FLOATS * i;
      const from = 3 * (start + i);
      data[to] = positions[from];
      data[to + 1] = positions[from + 1];
      data[to + 2] = positions[from + 2];
      for (let k = 4; k < FLOATS; k++) data[to + k] = 0;
    }
    const count = tets.length / 4;
    for (let t = 0; t < count; t++) {
      // Edges of the deformed tetrahedron, and their cross products: the columns of its cofactor.
      const at = 4 * t;
      const o = 3 * (start + tets[at]);
      const a = 3 * (start + tets[at + 1]);
      const b = 3 * (start + tets[at + 2]);
      const c = 3 * (start + tets[at + 3]);
      const ox = positions[o];
      const oy = positions[o + 1];
      const oz = positions[o + 2];
      const ax = positions[a] - ox;
      const ay = positions[a + 1] - oy;
      const az = positions[a + 2] - oz;
      const bx = positions[b] - ox;
      const by = positions[b + 1] - oy;
      const bz = positions[b + 2] - oz;
      const cx = positions[c] - ox;
      const cy = positions[c + 1] - oy;
      const cz = positions[c + 2] - oz;
      const ux = by * cz - bz * cy;
      const uy = bz * cx - bx * cz;
      const uz = bx * cy - by * cx;
      const vx = cy * az - cz * ay;
      const vy = cz * ax - cx * az;
      const vz = cx * ay - cy * ax;
      const wx = ay * bz - az * by;
      const wy = az * bx - ax * bz;
      const wz = ax * by - ay * bx;
      // cof(F) × volume = [u v w] · (rest edges)ᵀ / 6; column j takes the j-th numbers of the edges.
      const r = 9 * t;
      for (let j = 0; j < 3; j++) {
        const p = restEdges[r + j];
        const q = restEdges[r + 3 + j];
        const s = restEdges[r + 6 + j];
        const x = ux * p + vx * q + wx * s;
        const y = uy * p + vy * q + wy * s;
        const z = uz * p + vz * q + wz * s;
        for (let k = 0; k < 4; k++) {
          const to = FLOATS * tets[at + k] + 4 + 4 * j;
          data[to] += x;
          data[to + 1] += y;
          data[to + 2] += z;
        }
      }
    }
    for (let i = 0; i < nodeCount; i++) {
      const scale = perVolume[i];
      const to = FLOATS * i;
      for (let k = 4; k < FLOATS; k++) data[to + k] *= scale;
    }
    this.texture.needsUpdate = true;
  }

  dispose(): void {
    this.texture.dispose();
  }
}

function edges(x: Float32Array, start: number, tets: Uint32Array, t: number, out: Float64Array): void {
  const origin = 3 * (start + tets[4 * t]);
  for (let k = 0; k < 3; k++) {
    const node = 3 * (start + tets[4 * t + k + 1]);
    for (let c = 0; c < 3; c++) out[3 * k + c] = x[node + c] - x[origin + c];
  }
}

function determinant(m: Float64Array): number {
  return (
    m[0] * (m[4] * m[8] - m[5] * m[7]) -
    m[1] * (m[3] * m[8] - m[5] * m[6]) +
    m[2] * (m[3] * m[7] - m[4] * m[6])
  );
}
