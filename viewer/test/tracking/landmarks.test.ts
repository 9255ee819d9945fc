// 21 points to 25 joints: a tracked hand is reduced to its points, rebuilt and compared. Bones must
// fit within the little that trackers' frames differ from their own bones; the turn about the bone
// and the metacarpals' bases are guesses, and their bounds say how good.

import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { JOINT_NUMBERS, jointPosition, jointRotation, newHandJoints, type HandJoints } from "../../src/tracking/joints";
import { handFromLandmarks, LANDMARK_JOINTS } from "../../src/tracking/landmarks";
import { parseMotion } from "../../src/tracking/motion";
import { packJoints } from "../../src/tracking/pack";
import type { Side } from "../../src/protocol/types";
import { STORED_POSES, storedHand } from "./hands";

const DEGREE = Math.PI / 180;
const FINGER_BONES = [6, 7, 8, 9, 11, 12, 13, 14, 16, 17, 18, 19, 21, 22, 23, 24];
const THUMB = [1, 2, 3, 4];
const METACARPALS = [5, 10, 15, 20];

const points = (hand: HandJoints) =>
  LANDMARK_JOINTS.flatMap((joint) => [...hand.subarray(JOINT_NUMBERS * joint, JOINT_NUMBERS * joint + 3)]);

/** Angle between the same axis of a joint in two hands, rad. */
function axisAngle(a: HandJoints, b: HandJoints, joint: number, axis: Vector3): number {
  const turn = (hand: HandJoints) => axis.clone().applyQuaternion(jointRotation(hand, joint));
  return turn(a).angleTo(turn(b));
}

const BONE = new Vector3(0, 0, 1);
const HINGE = new Vector3(1, 0, 0);

function stored(side: Side, pose: (typeof STORED_POSES)[number]): HandJoints {
  const { matrices, radii } = storedHand(side, pose);
  const hand = newHandJoints();
  packJoints(matrices, radii, hand);
  return hand;
}

function worst(truth: HandJoints, rebuilt: HandJoints, joints: readonly number[], axis: Vector3): number {
  return Math.max(...joints.map((joint) => axisAngle(truth, rebuilt, joint, axis))) / DEGREE;
}

describe.each(["left", "right"] as const)("%s stored hands", (side) => {
  it.each(STORED_POSES)("%s", (pose) => {
    const truth = stored(side, pose);
    const rebuilt = handFromLandmarks(points(truth), side);
    for (const joint of LANDMARK_JOINTS) {
      expect(jointPosition(rebuilt, joint).distanceTo(jointPosition(truth, joint))).toBeLessThan(1e-7);
    }
    for (const joint of METACARPALS) {
      expect(jointPosition(rebuilt, joint).distanceTo(jointPosition(truth, joint))).toBeLessThan(0.014);
    }
    expect(worst(truth, rebuilt, [0], BONE)).toBeLessThan(3);
    expect(worst(truth, rebuilt, [0], HINGE)).toBeLessThan(3);
    expect(worst(truth, rebuilt, FINGER_BONES, BONE)).toBeLessThan(6);
    expect(worst(truth, rebuilt, FINGER_BONES, HINGE)).toBeLessThan(15);
    expect(worst(truth, rebuilt, THUMB, BONE)).toBeLessThan(6);
    expect(worst(truth, rebuilt, THUMB, HINGE)).toBeLessThan(30);
    // Radii of the same hand: sizes agree.
    for (let joint = 0; joint < 25; joint++) {
      const at = JOINT_NUMBERS * joint + 7;
      expect(Math.abs(rebuilt[at] / truth[at] - 1)).toBeLessThan(0.06);
    }
  });
});

describe("any frame", () => {
  it("turns with the points", () => {
    const hand = stored("right", "relaxed");
    const turn = new Quaternion(0.1, -0.7, 0.3, 0.5).normalize();
    const flat = points(hand);
    const turned: number[] = [];
    for (let i = 0; i < flat.length; i += 3) {
      turned.push(...new Vector3(flat[i], flat[i + 1], flat[i + 2]).applyQuaternion(turn).toArray());
    }
    const [a, b] = [handFromLandmarks(flat, "right"), handFromLandmarks(turned, "right")];
    for (let joint = 0; joint < 25; joint++) {
      const expected = turn.clone().multiply(jointRotation(a, joint));
      expect(jointRotation(b, joint).angleTo(expected)).toBeLessThan(1e-3);
    }
  });

  it("mirrors a left hand into a right one", () => {
    const hand = stored("left", "point");
    const flat = points(hand).map((x, i) => (i % 3 === 0 ? -x : x));
    const [a, b] = [handFromLandmarks(points(hand), "left"), handFromLandmarks(flat, "right")];
    for (let joint = 0; joint < 25; joint++) {
      const q = jointRotation(a, joint);
      expect(jointRotation(b, joint).angleTo(new Quaternion(q.x, -q.y, -q.z, q.w))).toBeLessThan(1e-3);
    }
  });

  it("refuses points that are no hand", () => {
    expect(() => handFromLandmarks(new Array<number>(63).fill(0.1), "right")).toThrow("do not form a hand");
  });
});

const capture = join(process.env["THENAR_MOTION_DIR"] ?? "", "quest3-two-hands-8s.jsonl");
describe.runIf(existsSync(capture))("a capture of a real headset", () => {
  it.each(["left", "right"] as const)("%s: median and 95th percentile of the angles", (side) => {
    const samples = parseMotion(readFileSync(capture, "utf8"), "capture").tracks[side]?.samples ?? [];
    expect(samples.length).toBeGreaterThan(600);
    const pairs = samples.map((truth) => [truth, handFromLandmarks(points(truth), side)] as const);
    const quantiles = (joints: readonly number[], axis: Vector3) => {
      const angles = pairs.flatMap(([a, b]) => joints.map((joint) => axisAngle(a, b, joint, axis) / DEGREE));
      angles.sort((p, q) => p - q);
      return [0.5, 0.95].map((share) => angles[Math.floor(share * angles.length)]);
    };
    const below = (found: number[], median: number, most: number) => {
      expect(found[0]).toBeLessThan(median);
      expect(found[1]).toBeLessThan(most);
    };
    below(quantiles([0], HINGE), 2, 3);
    below(quantiles(FINGER_BONES, BONE), 3, 6);
    below(quantiles(FINGER_BONES, HINGE), 5, 13);
    below(quantiles(THUMB, BONE), 3, 6);
    below(quantiles(THUMB, HINGE), 8, 20);
  });
});
