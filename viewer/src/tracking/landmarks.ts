// From 21 points without orientation (MediaPipe, Hand Tracking Streamer) to 25 joints with frames.
//
//   0 wrist | 1-4 thumb CMC MCP IP tip | 5-8 index MCP PIP DIP tip | 9- middle | 13- ring | 17-20 little
//
// Bones give -z. The back of the hand is the normal of the triangle wrist, index knuckle, little
// knuckle. The fingers' hinge (x) lies across the palm; where a finger is bent, the plane it bends
// in says more. The thumb's frame is turned from a typical one along with its bone.

import { Matrix4, Quaternion, Vector3 } from "three";
import type { Side } from "../protocol/types";
import { DIGIT_JOINTS, JOINT_NUMBERS, jointDistance, newHandJoints, type HandJoints } from "./joints";

export const LANDMARKS = 21;

/** WebXR joint of each landmark: all but the four finger metacarpals. */
export const LANDMARK_JOINTS = [
  0, 1, 2, 3, 4, 6, 7, 8, 9, 11, 12, 13, 14, 16, 17, 18, 19, 21, 22, 23, 24,
] as const;

/** Where the metacarpal of index, middle, ring, little begins, on the way wrist to knuckle. */
const METACARPAL_START = [0.39, 0.35, 0.38, 0.5];
/** Radii of an adult's hand of 0.19 m, m. */
const RADII = [
  0.0215, 0.019, 0.0123, 0.0098, 0.0088, 0.021, 0.0103, 0.0085, 0.0076, 0.0066, 0.021, 0.0112, 0.008,
  0.0076, 0.0066, 0.019, 0.0099, 0.0076, 0.0072, 0.0062, 0.018, 0.0085, 0.0068, 0.0064, 0.0054,
];
/** Wrist to middle fingertip along the bones for these radii, m. */
const RADII_LENGTH = 0.19;

/** Of a relaxed right hand, in the palm's frame: the thumb metacarpal's direction and its hinge. */
const THUMB_DIRECTION = new Vector3(-0.45, -0.48, -0.74).normalize();
const THUMB_HINGE = new Vector3(-0.2, 0.86, -0.49).normalize();
/** Trackers' wrists are rolled against the knuckles' triangle: about +z of a right hand, rad. */
const WRIST_ROLL = 0.145;
/** How much the plane a finger bends in counts against the line across the palm. */
const BEND_WEIGHT = 1;

/** Points: 63 numbers in m, right-handed, +y up or any other frame. The frame of the result is
 * that of the points. Throws if they lie so that no hand can be told. */
export function handFromLandmarks(points: ArrayLike<number>, side: Side): HandJoints {
  const hand = newHandJoints();
  LANDMARK_JOINTS.forEach((joint, i) => {
    for (let k = 0; k < 3; k++) hand[JOINT_NUMBERS * joint + k] = points[3 * i + k];
  });
  placeMetacarpals(hand);
  const palm = palmFrame(hand, side);
  const roll = side === "right" ? WRIST_ROLL : -WRIST_ROLL;
  writeRotation(hand, 0, palm.x.clone().applyAxisAngle(palm.z, roll), palm.z);
  DIGIT_JOINTS.forEach((joints, digit) => {
    const directions = joints.slice(1).map((joint, i) => between(hand, joints[i], joint));
    const hinge = digit === 0 ? thumbHinge(palm, side, directions) : fingerHinge(palm, directions);
    joints.forEach((joint, i) => {
      // A tip has the direction of the bone before it.
      const z = directions[Math.min(i, directions.length - 1)].clone().negate();
      writeRotation(hand, joint, hinge, z);
    });
  });
  writeRadii(hand);
  return hand;
}

interface Axes {
  readonly x: Vector3;
  readonly y: Vector3;
  readonly z: Vector3;
}

const at = (hand: HandJoints, joint: number) => new Vector3().fromArray(hand, JOINT_NUMBERS * joint);

function between(hand: HandJoints, from: number, to: number): Vector3 {
  return unit(at(hand, to).sub(at(hand, from)));
}

function unit(v: Vector3): Vector3 {
  const length = v.length();
  if (!(length > 1e-9)) throw new Error("The points do not form a hand.");
  return v.divideScalar(length);
}

function placeMetacarpals(hand: HandJoints): void {
  const wrist = at(hand, 0);
  METACARPAL_START.forEach((share, i) => {
    const [base, knuckle] = DIGIT_JOINTS[i + 1];
    wrist.clone().lerp(at(hand, knuckle), share).toArray(hand, JOINT_NUMBERS * base);
  });
}

/** -z to the middle knuckle, +y out of the back. */
function palmFrame(hand: HandJoints, side: Side): Axes {
  const toIndex = between(hand, 0, 6);
  const toLittle = between(hand, 0, 21);
  const back = toLittle.cross(toIndex).multiplyScalar(side === "right" ? 1 : -1);
  const z = between(hand, 11, 0);
  const x = unit(back.cross(z));
  return { x, y: z.clone().cross(x), z };
}

function fingerHinge(palm: Axes, directions: readonly Vector3[]): Vector3 {
  const across = unit(palm.y.clone().cross(directions[0].clone().negate()));
  return unit(across.addScaledVector(bend(directions.slice(1)), BEND_WEIGHT));
}

/** Axis a finger bends about: zero if straight, at most of the length of two right angles. */
function bend(directions: readonly Vector3[]): Vector3 {
  const axis = new Vector3();
  for (let i = 1; i < directions.length; i++) {
    // Flexion turns -z towards -y, about -x.
    axis.sub(new Vector3().crossVectors(directions[i - 1], directions[i]));
  }
  return axis;
}

function thumbHinge(palm: Axes, side: Side, directions: readonly Vector3[]): Vector3 {
  const basis = new Matrix4().makeBasis(palm.x, palm.y, palm.z);
  const mirror = side === "right" ? 1 : -1;
  const [d, h] = [THUMB_DIRECTION, THUMB_HINGE];
  // A mirrored frame keeps its hinge's x and turns the other two round.
  const direction = new Vector3(mirror * d.x, d.y, d.z).transformDirection(basis);
  const hinge = new Vector3(h.x, mirror * h.y, mirror * h.z).transformDirection(basis);
  hinge.applyQuaternion(new Quaternion().setFromUnitVectors(direction, directions[0]));
  return unit(hinge.addScaledVector(bend(directions), BEND_WEIGHT));
}

function writeRotation(hand: HandJoints, joint: number, hinge: Vector3, z: Vector3): void {
  const x = unit(hinge.clone().addScaledVector(z, -hinge.dot(z)));
  const y = z.clone().cross(x);
  new Quaternion()
    .setFromRotationMatrix(new Matrix4().makeBasis(x, y, z))
    .toArray(hand, JOINT_NUMBERS * joint + 3);
}

function writeRadii(hand: HandJoints): void {
  const length = [11, 12, 13, 14].reduce(
    (sum, joint) => sum + jointDistance(hand, joint, joint === 11 ? 0 : joint - 1),
    0,
  );
  RADII.forEach((radius, joint) => {
    hand[JOINT_NUMBERS * joint + 7] = (radius * length) / RADII_LENGTH;
  });
}
