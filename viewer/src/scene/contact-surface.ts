// Normals of a collision surface as it is now, at single vertices: contacts are few.

import { Vector3 } from "three";
import type { SoftModel } from "../protocol/types";

export class ContactSurface {
  /** Triangles around each vertex, as first indices in the list of triangles. */
  private readonly around: number[][];

  constructor(private readonly soft: SoftModel) {
    const { tets, triangles } = soft.collision;
    this.around = Array.from({ length: tets.length }, () => []);
    for (let t = 0; t < triangles.length; t++) this.around[triangles[t]].push(t - (t % 3));
  }

  /** Outward unit normal at a vertex for nodes at their present places; false if it has none. */
  normal(vertex: number, nodes: Float32Array, out: Vector3): boolean {
    out.set(0, 0, 0);
    const { triangles } = this.soft.collision;
    for (const t of this.around[vertex] ?? []) {
      this.place(triangles[t], nodes, O);
      this.place(triangles[t + 1], nodes, A).sub(O);
      this.place(triangles[t + 2], nodes, B).sub(O);
      out.add(A.cross(B));
    }
    if (out.lengthSq() < 1e-24) return false;
    out.normalize();
    return true;
  }

  private place(vertex: number, nodes: Float32Array, out: Vector3): Vector3 {
    const { soft } = this;
    const tet = soft.collision.tets[vertex];
    out.set(0, 0, 0);
    for (let k = 0; k < 4; k++) {
      const at = 3 * (soft.node_start + soft.tets[4 * tet + k]);
      const w = soft.collision.weights[4 * vertex + k];
      out.x += w * nodes[at];
      out.y += w * nodes[at + 1];
      out.z += w * nodes[at + 2];
    }
    return out;
  }
}

const O = new Vector3();
const A = new Vector3();
const B = new Vector3();
