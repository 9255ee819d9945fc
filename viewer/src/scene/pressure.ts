// Pressure on the skin, from contact forces. A contact presses at one vertex of the collision surface;
// its normal force is spread over the drawn skin around, along the rest shape, by a bell of 3 mm, or
// wider where the collision surface is coarser than that.
// The spread pressure times the area adds up to the force again.

import type { Contacts } from "../protocol/types";
import { NO_VERTEX, SOFT_BODY, type SoftModel } from "../protocol/types";
import { neighbours, restPositions, vertexAreas, type Neighbours } from "./surface";

/** Least width (standard deviation) of the bell, m; as a part of the spacing of collision vertices;
 * and where it is cut off, in widths. */
const WIDTH_LEAST = 0.003;
const WIDTH_OF_SPACING = 0.55;
const REACH = 3;

/** What one newton at a collision vertex gives: Pa at each of some vertices. */
interface Bell {
  readonly vertices: Uint32Array;
  readonly pascals: Float32Array;
}

export class PressureMap {
  private readonly rest: Float32Array;
  private readonly areas: Float32Array;
  private readonly around: Neighbours;
  private readonly collision: Float32Array;
  /** Of the bell at each collision vertex, m. */
  private readonly widths: Float32Array;
  private readonly bells = new Map<number, Bell>();

  constructor(soft: SoftModel) {
    this.rest = restPositions(soft.render, soft.nodes, soft.tets);
    this.areas = vertexAreas(this.rest, soft.render.triangles);
    this.around = neighbours(this.rest, soft.render.triangles);
    this.collision = restPositions(soft.collision, soft.nodes, soft.tets);
    this.widths = vertexAreas(this.collision, soft.collision.triangles).map((area) =>
      Math.max(WIDTH_LEAST, WIDTH_OF_SPACING * Math.sqrt(area)),
    );
  }

  /** Adds all contacts of this body, number `index` among the soft ones; gives the peak, Pa. */
  update(contacts: Contacts, index: number, out: Float32Array): number {
    out.fill(0);
    const body = SOFT_BODY + index;
    for (let i = 0; i < contacts.count; i++) {
      const force = Math.abs(contacts.numbers[12 * i + 8]);
      if (contacts.bodyA(i) === body) this.press(contacts.vertexA(i), force, out);
      else if (contacts.bodyB(i) === body) this.press(contacts.vertexB(i), force, out);
    }
    let most = 0;
    for (let v = 0; v < out.length; v++) if (out[v] > most) most = out[v];
    return most;
  }

  /** A normal force, N, at a collision vertex. */
  press(vertex: number, force: number, out: Float32Array): void {
    if (vertex === NO_VERTEX || 3 * vertex >= this.collision.length) return;
    let bell = this.bells.get(vertex);
    if (bell === undefined) {
      bell = this.spread(vertex);
      this.bells.set(vertex, bell);
    }
    for (let k = 0; k < bell.vertices.length; k++) out[bell.vertices[k]] += force * bell.pascals[k];
  }

  /** Walks over the skin from the nearest vertex, so that a force on one finger does not colour the
   * finger beside it. */
  private spread(vertex: number): Bell {
    const at = 3 * vertex;
    const width = this.widths[vertex];
    const reach = REACH * width;
    const square = (v: number) => {
      let sum = 0;
      for (let c = 0; c < 3; c++) sum += (this.rest[3 * v + c] - this.collision[at + c]) ** 2;
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
        if (seen.has(next) || square(next) > reach * reach) continue;
        seen.add(next);
        found.push(next);
      }
    }
    const shape = found.map((v) => Math.exp(-(square(v) - least) / (2 * width * width)));
    let whole = 0;
    found.forEach((v, k) => (whole += shape[k] * this.areas[v]));
    return {
      vertices: Uint32Array.from(found),
      pascals: Float32Array.from(shape, (s) => (whole > 0 ? s / whole : 0)),
    };
  }
}
