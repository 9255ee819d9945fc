// Arrows of a contact: along the normal that was sent, and along the rest of the force; on the hand.

import { Matrix4, Vector3, type InstancedMesh } from "three";
import { describe, expect, it } from "vitest";
import { roundUp } from "../src/scene/colour-map";
import { ContactView } from "../src/scene/contact-view";
import { decode } from "../src/protocol/decode";
import { encodeSnapshot, encodeWorld } from "./encode-world";

/** Tip of an arrow from its place, in m. */
function arrow(mesh: InstancedMesh): Vector3 {
  const matrix = new Matrix4();
  mesh.getMatrixAt(0, matrix);
  return new Vector3(0, 1, 0).applyMatrix4(matrix).sub(new Vector3().setFromMatrixPosition(matrix));
}

/** Arrows for normal force and friction: 3 N along z, 1.5 N of friction along x. */
function arrows(bodies: [number, number]): [Vector3, Vector3] {
  const message = decode(encodeWorld(), null, 0);
  if (message.kind !== "model") throw new Error(message.kind);
  const contact = {
    bodies,
    vertices: [65535, 65535] as const,
    numbers: [0.1, 0.2, 0.3, 1.5, 0, 3, 0, 1e-5, 0, 0],
    normal: [0, 0] as const,
  };
  const next = decode(encodeSnapshot(1, 0, [contact]), message.model, 0);
  if (next.kind !== "snapshot") throw new Error(next.kind);
  const view = new ContactView();
  view.setVisible(true, true);
  view.update(next.snapshot, message.model);
  // The longest arrow, of 50 mm, is that of the next of 1, 2, 5 N above.
  expect(view.forceMost).toBe(5);
  return [arrow(view.normals), arrow(view.shears)];
}

describe("the arrows of a contact", () => {
  it("show the force along the normal that was sent, and the rest", () => {
    // On the hand, whose flesh is the first soft body.
    const [normal, shear] = arrows([32768, 3]);
    expect(normal.distanceTo(new Vector3(0, 0, 0.03))).toBeLessThan(1e-5);
    expect(shear.distanceTo(new Vector3(0.015, 0, 0))).toBeLessThan(1e-5);
  });

  it("show the force on the hand where the hand is the other body", () => {
    const [normal, shear] = arrows([3, 32768]);
    expect(normal.distanceTo(new Vector3(0, 0, -0.03))).toBeLessThan(1e-5);
    expect(shear.distanceTo(new Vector3(-0.015, 0, 0))).toBeLessThan(1e-5);
  });
});

describe("the end of a scale", () => {
  it("is the next of 1, 2, 5", () => {
    expect([0.7, 1, 1.1, 2.1, 5.1, 0.021].map(roundUp)).toEqual([1, 1, 2, 5, 10, 0.05]);
  });
});
