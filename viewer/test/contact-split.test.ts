// A contact's force in its two parts: the normal part has the size that was sent, the two add up to
// the force and stand at a right angle, and the normal leans towards the skin's.

import { Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { roundUp } from "../src/scene/colour-map";
import { split } from "../src/scene/contact-view";

describe("a contact's force", () => {
  it("is split as it was put together", () => {
    const normal = new Vector3(1, 2, -2).normalize();
    const shear = new Vector3(2, 1, 2).normalize();
    const force = normal.clone().multiplyScalar(3).addScaledVector(shear, 1.5);
    // The skin's own normal is a little off.
    const guess = normal.clone().addScaledVector(shear, 0.2).normalize();
    const [n, t] = [new Vector3(), new Vector3()];
    split(force, 3, guess, n, t);
    expect(n.distanceTo(normal.multiplyScalar(3))).toBeLessThan(1e-9);
    expect(t.distanceTo(shear.multiplyScalar(1.5))).toBeLessThan(1e-9);
  });

  it("without friction is all normal, and no force gives no arrows", () => {
    const [n, t] = [new Vector3(), new Vector3()];
    split(new Vector3(0, 2, 0), 2, new Vector3(0.1, 1, 0), n, t);
    expect(n.toArray()).toEqual([0, 2, 0]);
    expect(t.length()).toBeLessThan(1e-9);
    split(new Vector3(), 0, new Vector3(0, 1, 0), n, t);
    expect(n.length() + t.length()).toBe(0);
  });
});

describe("the end of a scale", () => {
  it("is the next of 1, 2, 5", () => {
    expect([0.7, 1, 1.1, 2.1, 5.1, 0.021].map(roundUp)).toEqual([1, 1, 2, 5, 10, 0.05]);
  });
});
