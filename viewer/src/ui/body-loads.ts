// In scenes without a hand: what presses on each body.

import { PER_DIGIT, SOFT_BODY, type SceneModel, type Snapshot } from "../protocol/types";

/** As many rows as two hands have digits: the plot has columns for them. */
export const BODIES_MOST = 12;

/** In place of a row: the body has none. */
const NONE = -1;

/** The bodies of a scene that contact can move, and the sums of contact on each. */
export class BodyLoads {
  readonly names: readonly string[];
  /** Bodies beyond `BODIES_MOST`, which have no row. */
  readonly leftOut: number;
  private readonly rigidRow: readonly number[];
  private readonly softRow: readonly number[];
  private readonly force = { x: 0, y: 0, z: 0 };

  constructor({ softs, rigids }: Pick<SceneModel, "softs" | "rigids">) {
    const names = softs.map(({ name }) => name);
    // Bones of a figure bear the name of its flesh, and count with it.
    const owner = rigids.map(({ name }) => softs.findIndex((soft) => name.startsWith(`${soft.name}/`)));
    const row = (s: number) => (s < BODIES_MOST ? s : NONE);
    this.softRow = softs.map((_, s) => row(s));
    this.rigidRow = rigids.map(({ name, fixed, kind }, r) => {
      if (owner[r] >= 0) return row(owner[r]);
      if (fixed || kind === "none") return NONE;
      names.push(name);
      return row(names.length - 1);
    });
    this.names = names.slice(0, BODIES_MOST);
    this.leftOut = names.length - this.names.length;
  }

  /** Per body normal force N, shear force N, area m² and mean pressure Pa, laid out as digits are. Contacts of a body with
   * itself press on both sides alike and are left out. */
  sums(snapshot: Pick<Snapshot, "contacts">, out: Float32Array): void {
    out.fill(0, 0, PER_DIGIT * this.names.length);
    const { contacts } = snapshot;
    for (let i = 0; i < contacts.count; i++) {
      const [a, b] = [this.row(contacts.bodyA(i)), this.row(contacts.bodyB(i))];
      if (a === b) continue;
      contacts.force(i, this.force);
      const { x, y, z } = this.force;
      const normal = contacts.normalForce(i);
      const shear = Math.sqrt(Math.max(0, x * x + y * y + z * z - normal * normal));
      for (const row of [a, b]) {
        if (row === NONE) continue;
        const at = PER_DIGIT * row;
        out[at] += normal;
        out[at + 1] += shear;
        const area = contacts.area(i);
        out[at + 2] += area;
        // The force on areas for now; between rigid bodies there is no pressure.
        if (area > 0) out[at + 3] += normal;
      }
    }
    for (let at = 0; at < PER_DIGIT * this.names.length; at += PER_DIGIT) {
      out[at + 3] = out[at + 2] > 0 ? out[at + 3] / out[at + 2] : 0;
    }
  }

  private row(body: number): number {
    return (body < SOFT_BODY ? this.rigidRow[body] : this.softRow[body - SOFT_BODY]) ?? NONE;
  }
}
