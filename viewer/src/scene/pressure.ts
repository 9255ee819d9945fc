// Pressure on the skin: of each contact the normal force F over its area A. It is drawn around the
// contact's place as the bell F/A exp(-π r²/A), whose height is the pressure and whose integral is
// the force, over the drawn skin as it lies now. The sum over the drawn skin is the force again. A
// contact samples the skin at a collision vertex: its bell is no smaller than that vertex's share of
// the collision surface, for between the samples nothing is known.

import { Vector3 } from "three";
import type { Contacts, Snapshot } from "../protocol/types";
import { NO_VERTEX, SOFT_BODY, type SoftModel } from "../protocol/types";
import { neighbours, restPositions, vertexAreas, type Neighbours } from "./surface";

/** Where the bell is cut off, in roots of its area: there it has a thousandth of its height. */
const REACH = Math.sqrt(Math.log(1000) / Math.PI);

/** The drawn skin around a collision vertex, out to a distance at rest. */
interface Patch {
  readonly reach: number;
  readonly vertices: Uint32Array;
}

export class PressureMap {
  private readonly rest: Float32Array;
  private readonly areas: Float32Array;
  private readonly around: Neighbours;
  private readonly collision: Float32Array;
  private readonly shareOfVertex: Float32Array;
  private readonly patches = new Map<number, Patch>();
  private shares = new Float64Array(64);

  constructor(private readonly soft: SoftModel) {
    this.rest = restPositions(soft.render, soft.nodes, soft.tets);
    this.areas = vertexAreas(this.rest, soft.render.triangles);
    this.around = neighbours(this.rest, soft.render.triangles);
    this.collision = restPositions(soft.collision, soft.nodes, soft.tets);
    this.shareOfVertex = vertexAreas(this.collision, soft.collision.triangles);
  }

  /** Pressure at each drawn vertex by all contacts of this body, number `index` among the soft ones;
   * gives the peak, Pa. */
  update({ contacts, nodes }: Pick<Snapshot, "contacts" | "nodes">, index: number, out: Float32Array): number {
    out.fill(0);
    const body = SOFT_BODY + index;
    for (let i = 0; i < contacts.count; i++) {
      if (contacts.bodyA(i) === body) this.press(contacts, i, contacts.vertexA(i), nodes, out);
      if (contacts.bodyB(i) === body) this.press(contacts, i, contacts.vertexB(i), nodes, out);
    }
    let most = 0;
    for (let v = 0; v < out.length; v++) if (out[v] > most) most = out[v];
    return most;
  }

  /** Contact `i` presses near a collision vertex. */
  private press(contacts: Contacts, i: number, vertex: number, nodes: Float32Array, out: Float32Array): void {
    const force = contacts.normalForce(i);
    if (!(force > 0) || vertex === NO_VERTEX || 3 * vertex >= this.collision.length) return;
    contacts.place(i, PLACE);
    this.where(this.soft.collision, vertex, nodes, AT);
    const size = Math.sqrt(Math.max(contacts.area(i), this.shareOfVertex[vertex]));
    const { vertices } = this.patch(vertex, PLACE.distanceTo(AT) + REACH * size);
    // The skin shows nothing finer than one of its vertices.
    const area = Math.max(size * size, this.areas[vertices[0]]);
    if (this.shares.length < vertices.length) this.shares = new Float64Array(2 * vertices.length);
    let least = Infinity;
    vertices.forEach((v, k) => {
      this.where(this.soft.render, v, nodes, AT);
      this.shares[k] = PLACE.distanceToSquared(AT);
      least = Math.min(least, this.shares[k]);
    });
    let whole = 0;
    vertices.forEach((v, k) => {
      this.shares[k] = Math.exp((-Math.PI * (this.shares[k] - least)) / area);
      whole += this.shares[k] * this.areas[v];
    });
    if (!(whole > 0)) return;
    vertices.forEach((v, k) => (out[v] += (force * this.shares[k]) / whole));
  }

  /** Walks over the skin from the nearest vertex, so that a force on one finger does not colour the
   * finger beside it. */
  private patch(vertex: number, reach: number): Patch {
    const known = this.patches.get(vertex);
    if (known !== undefined && known.reach >= reach) return known;
    // Somewhat farther, so that a growing contact does not ask each time.
    const wide = 1.5 * reach;
    const square = (v: number) => {
      let sum = 0;
      for (let c = 0; c < 3; c++) sum += (this.rest[3 * v + c] - this.collision[3 * vertex + c]) ** 2;
      return sum;
    };
    let nearest = 0;
    let least = Infinity;
    for (let v = 0; v < this.areas.length; v++) {
      const d = square(v);
      if (d < least) [least, nearest] = [d, v];
    }
    const found = [nearest];
    const seen = new Set(found);
    for (let i = 0; i < found.length; i++) {
      for (let k = this.around.start[found[i]]; k < this.around.start[found[i] + 1]; k++) {
        const next = this.around.list[k];
        if (seen.has(next) || square(next) > wide * wide) continue;
        seen.add(next);
        found.push(next);
      }
    }
    const patch = { reach: wide, vertices: Uint32Array.from(found) };
    this.patches.set(vertex, patch);
    return patch;
  }

  /** Where a vertex of a surface lies now. */
  private where(surface: SoftModel["render"], vertex: number, nodes: Float32Array, out: Vector3): void {
    out.set(0, 0, 0);
    const tet = surface.tets[vertex];
    for (let k = 0; k < 4; k++) {
      const at = 3 * (this.soft.node_start + this.soft.tets[4 * tet + k]);
      const w = surface.weights[4 * vertex + k];
      out.x += w * nodes[at];
      out.y += w * nodes[at + 1];
      out.z += w * nodes[at + 2];
    }
  }
}

const PLACE = new Vector3();
const AT = new Vector3();
