// Built-in motions: within what joints allow, closed loops, and where they should be.

import { Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { BUILTIN_MOTIONS, builtinPose, duration } from "../../src/tracking/builtin";
import type { HandModel, Side } from "../../src/protocol/types";

const hand = (side: Side) =>
  ({ side, shapes: new Map(), angles: Array.from({ length: 20 }, () => ({ joint: "", rest: 0, min: -0.3, max: 1.4 })) }) as unknown as HandModel;

describe.each(BUILTIN_MOTIONS)("$title", (motion) => {
  it("ends as it begins, moves smoothly and stays in range", () => {
    const end = duration(motion);
    let before = builtinPose(motion, 0, hand("right"), new Vector3());
    const first = before;
    for (let t = 0; t <= end; t += 0.01) {
      const pose = builtinPose(motion, t, hand("right"), new Vector3());
      pose.angles.forEach((angle, i) => {
        expect(angle).toBeGreaterThanOrEqual(-0.3);
        expect(angle).toBeLessThanOrEqual(1.4);
        // Slower than 7 rad/s.
        expect(Math.abs(angle - before.angles[i])).toBeLessThan(0.07);
      });
      expect(Math.hypot(...pose.wrist.slice(0, 3).map((x, k) => x - before.wrist[k]))).toBeLessThan(0.01);
      expect(pose.wrist[1]).toBeGreaterThan(0.03);
      expect(Math.hypot(...pose.wrist.slice(3))).toBeCloseTo(1, 6);
      before = pose;
    }
    const last = builtinPose(motion, end, hand("right"), new Vector3());
    last.wrist.forEach((x, i) => expect(x).toBeCloseTo(first.wrist[i], 9));
    last.angles.forEach((x, i) => expect(x).toBeCloseTo(first.angles[i], 9));
  });

  it("turns a left hand as the mirror of a right one", () => {
    for (const t of [0.2, 0.7, 1.1]) {
      const [left, right] = (["left", "right"] as const).map((side) =>
        new Quaternion().fromArray(builtinPose(motion, t, hand(side), new Vector3()).wrist, 3),
      );
      const mirrored = new Quaternion(right.x, -right.y, -right.z, right.w);
      expect(left.angleTo(mirrored)).toBeLessThan(1e-6);
    }
  });
});
