// Where the world stands before the visitor, and the gesture that brings it back.

import { Euler, Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { AHEAD, BELOW_EYES, placeWorld, TABLE_MIN } from "../../src/xr/anchor";
import { RecentreGesture } from "../../src/xr/recentre";
import { inverse, type Rigid } from "../../src/tracking/rigid";
import { straightHand } from "../tracking/hands";

const head = (x: number, y: number, z: number, pitch = 0, yaw = 0, roll = 0): Rigid => ({
  position: new Vector3(x, y, z),
  rotation: new Quaternion().setFromEuler(new Euler(pitch, yaw, roll, "YXZ")),
});
const toWorld = (point: Vector3, world: Rigid) => {
  const back = inverse(world);
  return point.clone().applyQuaternion(back.rotation).add(back.position);
};

describe("placing the world", () => {
  const centre = new Vector3(0.02, 0.085, 0.03);

  it("puts the middle of the scene ahead and the table below the eyes", () => {
    const world = placeWorld(head(1, 1.6, 2), centre, true);
    const middle = toWorld(new Vector3(1, 1.6 - BELOW_EYES, 2 - AHEAD), world);
    expect(middle.distanceTo(new Vector3(centre.x, 0, centre.z))).toBeLessThan(1e-9);
  });

  it("turns with the visitor, whose side is +z, and stays level and at true scale", () => {
    for (const yaw of [-2.5, -0.4, 0, 1, 3]) {
      const visitor = head(0.3, 1.5, -0.2, -0.7, yaw, 0.3);
      const world = placeWorld(visitor, centre, true);
      const up = new Vector3(0, 1, 0).applyQuaternion(world.rotation);
      expect(up.y).toBeCloseTo(1, 9);
      const seen = toWorld(visitor.position, world);
      expect(seen.x).toBeCloseTo(centre.x, 6);
      expect(seen.z).toBeCloseTo(centre.z + AHEAD, 6);
      expect(seen.y).toBeCloseTo(BELOW_EYES, 6);
    }
  });

  it("knows ahead also when the visitor looks straight down or up", () => {
    for (const pitch of [-Math.PI / 2, Math.PI / 2, -1.5, 1.5]) {
      const world = placeWorld(head(0, 1.6, 0, pitch, 0.8), centre, true);
      const z = new Vector3(0, 0, 1).applyQuaternion(world.rotation);
      expect(z.distanceTo(new Vector3(Math.sin(0.8), 0, Math.cos(0.8)))).toBeLessThan(1e-6);
    }
  });

  it("keeps the table off a known floor, and does not know a floor otherwise", () => {
    expect(placeWorld(head(0, 0.8, 0), centre, true).position.y).toBeCloseTo(TABLE_MIN, 9);
    expect(placeWorld(head(0, 0, 0), centre, false).position.y).toBeCloseTo(-BELOW_EYES, 9);
  });
});

describe("the gesture that recentres", () => {
  const chains = [0.14, 0.18, 0.19, 0.18, 0.16];
  const hand = (x: number, gap: number) => {
    const joints = straightHand(chains, 0.01);
    for (let at = 0; at < joints.length; at += 8) joints[at] += x;
    // Thumb tip (joint 4) to `gap` from the index tip (joint 9).
    joints.set([joints[72] + gap, joints[73], joints[74]], 32);
    return joints;
  };
  const centre = new Vector3();
  const run = (at: (t: number) => [number, number], touching = false) => {
    const gesture = new RecentreGesture();
    const fired: number[] = [];
    for (let i = 0; i < 60; i++) {
      const t = i / 10;
      const [x, gap] = at(t);
      if (gesture.update(hand(x, gap), centre, touching, t)) fired.push(t);
    }
    return fired;
  };

  it("fires once after two seconds of a still pinch away from the scene", () => {
    const fired = run(() => [0.5, 0.01]);
    expect(fired.length).toBe(1);
    expect(fired[0]).toBeCloseTo(2, 5);
  });

  it("does not fire near the scene, open, moving or touching", () => {
    expect(run(() => [0.1, 0.01])).toEqual([]);
    expect(run(() => [0.5, 0.05])).toEqual([]);
    expect(run((t) => [0.5 + 0.2 * t, 0.01])).toEqual([]);
    expect(run(() => [0.5, 0.01], true)).toEqual([]);
  });

  it("needs a new pinch to fire again", () => {
    const fired = run((t) => [0.5, t > 2.5 && t < 3 ? 0.05 : 0.01]);
    expect(fired.length).toBe(2);
  });
});
