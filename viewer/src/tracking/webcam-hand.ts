// A hand in the world from what a webcam shows of it.
//
// MediaPipe gives 21 points twice: in the picture (x, y from 0 to 1, y down) and in metres about the
// hand's middle (x right in the picture, y down, z away from the camera). The camera looks at the
// visitor, who stands at +z and looks along -z: picture right is world -x, away is world +z. All
// three together are a rotation, so hands stay what they are.
//
// Distance comes from how large the hand is in the picture, with a guess of the camera's angle; only
// changes of it count. A hand held up before a camera has its palm to the screen, where a hand at a
// table has it down: `tilt` turns it over about the wrist.

import { Quaternion, Vector3 } from "three";
import type { Side } from "../protocol/types";
import { JOINTS, JOINT_NUMBERS, type HandJoints } from "./joints";
import { handFromLandmarks, LANDMARKS } from "./landmarks";
import { moveJoints } from "./rigid";
import { sizeOf } from "./size";

export interface Point {
  readonly x: number;
  readonly y: number;
  readonly z: number;
}

/** Half of a webcam's view across, rad: most have 60 to 70 degrees. */
const HALF_VIEW = (65 / 2) * (Math.PI / 180);

/** Picture and metres in world directions: 63 numbers, and where the wrist is from the camera. */
export interface Seen {
  readonly points: Float64Array;
  /** x right, y up, z towards the visitor, from the camera, m. */
  readonly wrist: Vector3;
}

/** `aspect`: width over height of the picture. Null if the points show no extent. */
export function seen(picture: readonly Point[], metres: readonly Point[], aspect: number): Seen | null {
  if (picture.length !== LANDMARKS || metres.length !== LANDMARKS) return null;
  const points = new Float64Array(3 * LANDMARKS);
  metres.forEach(({ x, y, z }, i) => points.set([-x, -y, z], 3 * i));
  // Both in units of the picture's width.
  const across = spread(picture.map(({ x, y }) => [x, y / aspect] as const));
  const metric = spread(metres.map(({ x, y }) => [x, y] as const));
  if (!(across > 1e-6) || !(metric > 1e-4)) return null;
  const scale = across / metric;
  const { x, y } = picture[0];
  const distance = 0.5 / Math.tan(HALF_VIEW) / scale;
  const wrist = new Vector3(-(x - 0.5) / scale, -(y - 0.5) / aspect / scale, distance);
  return [...points, ...wrist].every(Number.isFinite) ? { points, wrist } : null;
}

/** Root mean square distance from the middle. */
function spread(points: readonly (readonly [number, number])[]): number {
  const n = points.length;
  const [x, y] = [0, 1].map((k) => points.reduce((sum, p) => sum + p[k], 0) / n);
  return Math.sqrt(points.reduce((sum, p) => sum + (p[0] - x) ** 2 + (p[1] - y) ** 2, 0) / n);
}

export interface WebcamPlace {
  /** Middle of the scene, world, m. */
  readonly centre: Vector3;
  /** Distance from the camera that counts as the middle, m. */
  readonly distance: number;
  /** About the wrist, fingers away from the visitor, rad. */
  readonly tilt: number;
  /** Wrist to fingertip of the simulated hand, m. */
  readonly length: number;
}

/** Middle of the picture above the middle of the scene, m; fingers reach 0.15 m beyond the wrist. */
const ABOVE = 0.16;
const BEFORE = 0.12;
/** Of a change of distance: it is the least certain. */
const DEPTH_GAIN = 0.7;
/** The wrist's least height above the table, m, and its furthest from the middle. */
const WRIST_LOWEST = 0.02;
const REACH = 0.5;

/** Null if the points form no hand. */
export function placeWebcamHand(from: Seen, side: Side, place: WebcamPlace): HandJoints | null {
  let hand: HandJoints;
  try {
    hand = handFromLandmarks(from.points, side);
  } catch {
    return null;
  }
  const size = sizeOf(hand);
  if (size === null) return null;
  const wrist = new Vector3().fromArray(hand);
  scaleAbout(hand, wrist, place.length / size.length);
  const rotation = new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), -place.tilt);
  const goal = new Vector3(
    from.wrist.x,
    from.wrist.y + ABOVE,
    DEPTH_GAIN * (from.wrist.z - place.distance) + BEFORE,
  ).clampLength(0, REACH);
  goal.y = Math.max(WRIST_LOWEST, goal.y);
  goal.x += place.centre.x;
  goal.z += place.centre.z;
  moveJoints(hand, { rotation, position: goal.sub(wrist.applyQuaternion(rotation)) });
  return hand;
}

function scaleAbout(hand: HandJoints, origin: Vector3, factor: number): void {
  const start = origin.toArray();
  for (let joint = 0; joint < JOINTS; joint++) {
    const at = JOINT_NUMBERS * joint;
    for (let k = 0; k < 3; k++) hand[at + k] = start[k] + factor * (hand[at + k] - start[k]);
    hand[at + 7] *= factor;
  }
}
