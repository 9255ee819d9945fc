// A hand is shown to a made-up camera and must come out where and as it was, up to the tilt.

import { Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import type { Side } from "../../src/protocol/types";
import { jointPosition, jointRotation, newHandJoints } from "../../src/tracking/joints";
import { LANDMARK_JOINTS } from "../../src/tracking/landmarks";
import { packJoints } from "../../src/tracking/pack";
import { sizeOf } from "../../src/tracking/size";
import { placeWebcamHand, seen, type Point } from "../../src/tracking/webcam-hand";
import { storedHand } from "./hands";

const ASPECT = 4 / 3;
/** Across, rad; the code guesses 65 degrees. */
const VIEW = (65 * Math.PI) / 180;

/** World points of a relaxed hand, fingers up and palm to the screen, wrist at the origin. */
function upright(side: Side): Vector3[] {
  const { matrices, radii } = storedHand(side, "relaxed");
  const hand = newHandJoints();
  packJoints(matrices, radii, hand);
  const wrist = jointPosition(hand, 0);
  const level = jointRotation(hand, 0).conjugate();
  // From fingers along -z, back up, to fingers up, back to the visitor: a quarter turn about x.
  const up = new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), Math.PI / 2);
  return LANDMARK_JOINTS.map((joint) =>
    jointPosition(hand, joint).sub(wrist).applyQuaternion(level).applyQuaternion(up),
  );
}

/** What the camera at the origin, looking along +z, and MediaPipe make of points in the world. */
function shown(world: readonly Vector3[], wrist: Vector3): { picture: Point[]; metres: Point[] } {
  const focal = 0.5 / Math.tan(VIEW / 2);
  const picture = world.map((offset) => {
    const p = offset.clone().add(wrist);
    return { x: 0.5 - (focal * p.x) / p.z, y: 0.5 - (ASPECT * focal * p.y) / p.z, z: 0 };
  });
  const middle = world.reduce((sum, p) => sum.add(p), new Vector3()).divideScalar(world.length);
  const metres = world.map((p) => ({ x: middle.x - p.x, y: middle.y - p.y, z: p.z - middle.z }));
  return { picture, metres };
}

describe.each(["left", "right"] as const)("%s hand", (side) => {
  const world = upright(side);
  const wrist = new Vector3(0.1, -0.06, 0.6);

  it("is found at its place, distance within a twentieth", () => {
    const { picture, metres } = shown(world, wrist);
    const found = seen(picture, metres, ASPECT);
    expect(found).not.toBeNull();
    // The scale is one for the whole hand: what is nearer looks larger, by some percent.
    expect(Math.abs((found?.wrist.z ?? 0) / wrist.z - 1)).toBeLessThan(0.05);
    expect(Math.abs((found?.wrist.x ?? 0) - wrist.x)).toBeLessThan(0.01);
    expect(Math.abs((found?.wrist.y ?? 0) - wrist.y)).toBeLessThan(0.01);
  });

  it("keeps its shape, takes the model's length and lies down by the tilt", () => {
    const { picture, metres } = shown(world, wrist);
    const found = seen(picture, metres, ASPECT);
    if (found === null) throw new Error("not seen");
    const place = { centre: new Vector3(0.02, 0.3, 0.02), distance: found.wrist.z, length: 0.17 };
    const upright = placeWebcamHand(found, side, { ...place, tilt: 0 });
    const flat = placeWebcamHand(found, side, { ...place, tilt: Math.PI / 2 });
    if (upright === null || flat === null) throw new Error("no hand");
    expect(sizeOf(flat)?.length).toBeCloseTo(0.17, 3);
    // At the camera's middle distance: 0.12 m before the middle of the scene, and where it is shown.
    expect(jointPosition(flat, 0).distanceTo(new Vector3(0.12, 0.1, 0.14))).toBeLessThan(0.015);
    expect(jointPosition(flat, 0).distanceTo(jointPosition(upright, 0))).toBeLessThan(1e-6);
    const ahead = (hand: Float32Array) => new Vector3(0, 0, -1).applyQuaternion(jointRotation(hand, 0));
    const back = (hand: Float32Array) => new Vector3(0, 1, 0).applyQuaternion(jointRotation(hand, 0));
    // Fingers up and back to the visitor; turned over, fingers away and back up.
    expect(ahead(upright).y).toBeGreaterThan(0.99);
    expect(back(upright).z).toBeGreaterThan(0.99);
    expect(ahead(flat).z).toBeLessThan(-0.99);
    expect(back(flat).y).toBeGreaterThan(0.99);
    // The right thumb is to the left of a hand that lies palm down.
    const thumb = jointPosition(flat, 4).x - jointPosition(flat, 0).x;
    expect(Math.sign(thumb)).toBe(side === "right" ? -1 : 1);
  });

  it("follows to the right when the hand goes to the right, and nearer when it comes nearer", () => {
    const at = (where: Vector3) => {
      const { picture, metres } = shown(world, where);
      const found = seen(picture, metres, ASPECT);
      if (found === null) throw new Error("not seen");
      const place = { centre: new Vector3(), distance: 0.6, tilt: 1.3, length: 0.19 };
      const hand = placeWebcamHand(found, side, place);
      if (hand === null) throw new Error("no hand");
      return jointPosition(hand, 0);
    };
    const middle = at(new Vector3(0, 0, 0.6));
    expect(at(new Vector3(0.1, 0, 0.6)).x - middle.x).toBeGreaterThan(0.08);
    expect(at(new Vector3(0, 0.05, 0.6)).y - middle.y).toBeGreaterThan(0.04);
    // Towards the screen is away from the visitor: -z.
    expect(at(new Vector3(0, 0, 0.5)).z - middle.z).toBeLessThan(-0.05);
    // Never into the table.
    expect(at(new Vector3(0, -0.4, 0.6)).y).toBeCloseTo(0.02, 6);
  });
});

describe("what is no hand", () => {
  it("is refused", () => {
    const point = { x: 0.5, y: 0.5, z: 0 };
    const flat = new Array<Point>(21).fill(point);
    expect(seen(flat, flat, ASPECT)).toBeNull();
    expect(seen([point], [point], ASPECT)).toBeNull();
    const { picture, metres } = shown(upright("left"), new Vector3(0, 0, 0.5));
    expect(seen(picture, metres.map((p) => ({ ...p, x: NaN })), ASPECT)).toBeNull();
  });
});
