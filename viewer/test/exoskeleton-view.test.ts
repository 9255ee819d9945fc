// Tendons over a straight finger whose places are worked out by hand.

import { Mesh, Vector3, type MeshStandardMaterial } from "three";
import { expect, it } from "vitest";
import type { HandModel, Side } from "../src/protocol/types";
import { ExoskeletonView, pulls } from "../src/scene/exoskeleton-view";

const RADIUS = 0.006;
/** A palm at the origin whose fingers point along -z with the back up; bones of fingers lie along their own y axis, backs
 * along `back` times their z axis. */
function hand(side: Side, back: number): { model: HandModel; rigids: Float32Array } {
  const bone = (name: string, parent: number | null, digit: "palm" | "index") => ({
    name,
    parent,
    digit,
    ends_B: [
      [0, 0, 0],
      [0, 0.03, 0],
    ] as const,
    radius: RADIUS,
    mass: 0.01,
  });
  const bones = [bone("palm", null, "palm"), ...["a", "b", "c"].map((name, k) => bone(name, k, "index"))];
  // Both take y to -z: z comes to +y by a turn about x, to -y by half a turn about the bisector of y and -z.
  const turn = back > 0 ? [-Math.SQRT1_2, 0, 0, Math.SQRT1_2] : [0, Math.SQRT1_2, -Math.SQRT1_2, 0];
  const rigids = [0, 0, 0, 0, 0, 0, 1];
  for (let k = 0; k < 3; k++) rigids.push(0.02, 0, -0.08 - 0.03 * k, ...turn);
  const model: HandModel = {
    name: "hand",
    side,
    soft: null,
    length: 0.18,
    bone_start: 0,
    bone_count: 4,
    target_start: 0,
    bones,
    wrist_B: [0, 0, 0, 0, 0, 0, 1],
    angles: [],
    shapes: new Map(),
    collision_digits: new Uint8Array(),
    cuff: null,
  };
  return { model, rigids: Float32Array.from(rigids) };
}

/** Ends and radius of the tendon's segments. */
function segments(view: ExoskeletonView): { from: Vector3; to: Vector3; radius: number; mesh: Mesh }[] {
  view.group.updateMatrixWorld(true);
  const unit = view.group.children.filter(
    (part): part is Mesh => part instanceof Mesh && part.geometry.parameters?.radiusTop === 1,
  );
  return unit.map((mesh) => ({
    from: mesh.localToWorld(new Vector3(0, -0.5, 0)),
    to: mesh.localToWorld(new Vector3(0, 0.5, 0)),
    radius: mesh.scale.x,
    mesh,
  }));
}

for (const side of ["left", "right"] as const) {
  for (const back of [1, -1]) {
    it(`a tendon runs over the back of the finger to its tip: ${side}, ${back}`, () => {
      const { model, rigids } = hand(side, back);
      const view = new ExoskeletonView(model);
      view.setForces([0, 3, 0, 0, 0], 6);
      view.update(rigids);
      const parts = segments(view);
      expect(parts.length).toBe(3);
      parts.slice(1).forEach(({ from }, k) => expect(from.distanceTo(parts[k].to)).toBeLessThan(1e-6));
      // Above the middle of each bone, and at four fifths of the last one, on its skin.
      for (const [k, along] of [0.095, 0.125, 0.164].entries()) {
        const { to } = parts[k];
        expect(to.x).toBeCloseTo(0.02, 6);
        expect(to.z).toBeCloseTo(-along, 6);
        expect(to.y).toBeGreaterThan(RADIUS);
      }
      expect(parts[2].to.y).toBeLessThan(0.015);
      // The plate is above the back, towards the thumb for the index finger: to the left of a right hand.
      expect(parts[0].from.y).toBeCloseTo(0.03, 6);
      expect(Math.sign(parts[0].from.x)).toBe(side === "right" ? -1 : 1);
    });
  }
}

it("force makes a tendon thicker and warmer", () => {
  const { model, rigids } = hand("right", 1);
  const view = new ExoskeletonView(model);
  const at = (force: number) => {
    view.setForces([0, force, 0, 0, 0], 6);
    view.update(rigids);
    const [{ radius, mesh }] = segments(view);
    return { radius, red: (mesh.material as MeshStandardMaterial).color.r };
  };
  const [slack, half, full] = [at(0), at(3), at(6)];
  expect(half.radius).toBeCloseTo((slack.radius + full.radius) / 2, 9);
  expect(full.radius).toBeGreaterThan(2 * slack.radius);
  expect(slack.red).toBeLessThan(half.red);
  expect(half.red).toBeLessThan(full.red);
});

it("without a device with tendons nothing is drawn", () => {
  const view = new ExoskeletonView(hand("right", 1).model);
  expect(view.group.visible).toBe(false);
  view.setForces([1, 1, 1, 1, 1], 6);
  expect(view.group.visible).toBe(true);
  view.setForces(null, 0);
  expect(view.group.visible).toBe(false);
});

it("pulls stay between nothing and all, whatever comes", () => {
  expect(pulls([-1, 3, 99, NaN, 0], 6)).toEqual([0, 0.5, 1, 0, 0]);
  expect(pulls([1], 0)).toEqual([0]);
});
