// Motions that come along, written as shapes of the hand and ways of the wrist.

import { Quaternion, Vector3 } from "three";
import type { HandModel } from "../protocol/types";
import { between, clampAngles, type Preset } from "../input/shapes";

interface Key {
  /** s */
  readonly time: number;
  readonly shape: Preset;
  /** Wrist from the place above the middle of the scene, m. */
  readonly shift: readonly [number, number, number];
  /** Pitch, yaw and roll of the wrist, degrees; level with the fingers away from the visitor at 0. */
  readonly turn: readonly [number, number, number];
}

export interface BuiltinMotion {
  readonly id: string;
  readonly title: string;
  readonly keys: readonly Key[];
}

const still = [0, 0, 0] as const;

export const BUILTIN_MOTIONS: readonly BuiltinMotion[] = [
  {
    id: "shapes",
    title: "Open, point, pinch, close",
    keys: [
      { time: 0, shape: "open", shift: still, turn: still },
      { time: 1, shape: "point", shift: still, turn: still },
      { time: 2, shape: "pinch", shift: still, turn: [0, 0, 20] },
      { time: 3, shape: "fist", shift: still, turn: still },
      { time: 4, shape: "open", shift: still, turn: still },
    ],
  },
  {
    id: "wave",
    title: "Wave",
    keys: [
      { time: 0, shape: "open", shift: [0, 0.03, 0], turn: [60, 0, 0] },
      { time: 0.5, shape: "open", shift: [-0.04, 0.03, 0], turn: [60, 0, 25] },
      { time: 1, shape: "open", shift: [0.04, 0.03, 0], turn: [60, 0, -25] },
      { time: 1.5, shape: "open", shift: [0, 0.03, 0], turn: [60, 0, 0] },
    ],
  },
  {
    id: "press",
    title: "Press down and lift",
    keys: [
      { time: 0, shape: "relaxed", shift: still, turn: still },
      { time: 1.2, shape: "relaxed", shift: [0, -0.12, 0], turn: [-10, 0, 0] },
      { time: 2.2, shape: "power-grasp", shift: [0, -0.12, 0], turn: [-10, 0, 0] },
      { time: 3, shape: "relaxed", shift: [0, -0.12, 0], turn: [-10, 0, 0] },
      { time: 4, shape: "relaxed", shift: still, turn: still },
    ],
  },
];

/** Wrist above the middle of the scene, m: the fingers reach over the middle. */
const ABOVE = new Vector3(0, 0.17, 0.12);
const DEGREE = Math.PI / 180;

export interface BuiltinPose {
  readonly wrist: number[];
  readonly angles: Float64Array;
}

export function duration(motion: BuiltinMotion): number {
  return motion.keys[motion.keys.length - 1].time;
}

/** The pose at `time` (s, within the motion), easing from key to key. */
export function builtinPose(
  motion: BuiltinMotion,
  time: number,
  hand: HandModel,
  centre: Vector3,
): BuiltinPose {
  const last = motion.keys.length - 1;
  const next = motion.keys.findIndex((key) => key.time > time);
  const to = motion.keys[next < 0 ? last : Math.max(1, next)];
  const from = motion.keys[next < 0 ? last - 1 : Math.max(0, next - 1)];
  const linear = Math.min(1, Math.max(0, (time - from.time) / (to.time - from.time)));
  const share = linear * linear * (3 - 2 * linear);

  const angles = clampAngles(between(from.shape, to.shape, share, hand), hand);
  const position = new Vector3(...from.shift)
    .lerp(new Vector3(...to.shift), share)
    .add(ABOVE)
    .add(new Vector3(centre.x, 0, centre.z));
  const rotation = turned(from, hand).slerp(turned(to, hand), share);
  return { wrist: [...position.toArray(), ...rotation.toArray()], angles };
}

function turned(key: Key, hand: HandModel): Quaternion {
  const mirror = hand.side === "right" ? 1 : -1;
  const [pitch, yaw, roll] = key.turn;
  const about = (x: number, y: number, z: number, degrees: number) =>
    new Quaternion().setFromAxisAngle(new Vector3(x, y, z), degrees * DEGREE);
  return about(0, 1, 0, mirror * yaw)
    .multiply(about(1, 0, 0, pitch))
    .multiply(about(0, 0, 1, mirror * roll));
}
