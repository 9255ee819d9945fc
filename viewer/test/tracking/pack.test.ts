// WebXR's matrices become positions and quaternions, and move from frame to frame.

import { Euler, Matrix4, Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { JOINTS, JOINT_NAMES, JOINT_NUMBERS, newHandJoints } from "../../src/tracking/joints";
import { packJoints } from "../../src/tracking/pack";
import { inverse, moveJoints, type Rigid } from "../../src/tracking/rigid";
import { storedHand } from "./hands";

function matricesOf(rotation: Quaternion, position: Vector3): Float32Array {
  const matrices = new Float32Array(16 * JOINTS);
  const one = new Matrix4().makeRotationFromQuaternion(rotation).setPosition(position);
  for (let joint = 0; joint < JOINTS; joint++) one.toArray(matrices, 16 * joint);
  return matrices;
}

describe("packing", () => {
  it("names 25 joints once each", () => {
    expect(new Set(JOINT_NAMES).size).toBe(25);
    expect(JOINT_NAMES[24]).toBe("pinky-finger-tip");
  });

  it("reads column-major matrices: a quarter turn about y takes -z to -x", () => {
    // Written out by hand: columns are the images of x, y, z, and the place.
    const matrices = new Float32Array(16 * JOINTS);
    for (let joint = 0; joint < JOINTS; joint++) {
      matrices.set([0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 2, 3, 1], 16 * joint);
    }
    const out = newHandJoints();
    expect(packJoints(matrices, new Float32Array(JOINTS).fill(0.01), out)).toBe(true);
    const last = [...out.subarray(JOINT_NUMBERS * 24)];
    [1, 2, 3, 0, Math.SQRT1_2, 0, Math.SQRT1_2, 0.01].forEach((x, i) => expect(last[i]).toBeCloseTo(x, 6));
  });

  it("keeps every rotation up to sign, also half turns", () => {
    const out = newHandJoints();
    for (let i = 0; i < 200; i++) {
      const q = new Quaternion().setFromEuler(new Euler(i, 2.3 * i, Math.PI * (i % 3)));
      packJoints(matricesOf(q, new Vector3(i, 0, 0)), new Float32Array(JOINTS), out);
      const got = new Quaternion().fromArray(out, 3);
      expect(Math.abs(got.dot(q))).toBeCloseTo(1, 5);
      expect(got.length()).toBeCloseTo(1, 6);
    }
  });

  it("refuses what is not finite and leaves the hand as it was", () => {
    const matrices = matricesOf(new Quaternion(), new Vector3());
    matrices[16 * 7 + 13] = NaN;
    const out = newHandJoints().fill(5);
    expect(packJoints(matrices, new Float32Array(JOINTS), out)).toBe(false);
    expect(out.every((x) => x === 5)).toBe(true);
  });

  it("moves joints and back", () => {
    const { matrices, radii } = storedHand("right", "pinch");
    const before = newHandJoints();
    packJoints(matrices, radii, before);
    const motion: Rigid = {
      position: new Vector3(0.4, -0.2, 1.1),
      rotation: new Quaternion().setFromEuler(new Euler(0.3, -1.2, 0.7)),
    };
    const hand = before.slice();
    moveJoints(hand, motion);
    const tip = new Vector3(...before.subarray(72, 75)).applyQuaternion(motion.rotation).add(motion.position);
    expect(tip.distanceTo(new Vector3(...hand.subarray(72, 75)))).toBeLessThan(1e-6);
    moveJoints(hand, inverse(motion));
    hand.forEach((x, i) => expect(x).toBeCloseTo(before[i], 5));
  });
});
