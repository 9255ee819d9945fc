// Shapes of the hand in joint angles, and what the sliders do to them. Angles are those of
// `hands[].angles`: per digit, thumb first, base flexion, base spread, second flexion, third
// flexion; positive flexion closes the hand.

import type { HandModel } from "../protocol/types";

export const DIGIT_COUNT = 5;
export const ANGLE_COUNT = 20;
export type Angles = Float64Array;

export const PRESETS = ["open", "relaxed", "fist", "point", "pinch", "power-grasp"] as const;
export type Preset = (typeof PRESETS)[number];

/** Base, second and third flexion, and spread, degrees. */
type DigitShape = readonly [number, number, number, number];
interface Shape {
  readonly thumb: DigitShape;
  readonly index: DigitShape;
  readonly others: DigitShape;
}

const CLOSED: DigitShape = [80, 92, 50, 0];

// The same shapes as those of the scene files' keyframes.
const SHAPES: Readonly<Record<Preset, Shape>> = {
  open: { thumb: [0, 0, 0, 0], index: [0, 0, 0, 4], others: [0, 0, 0, 4] },
  relaxed: { thumb: [5, 12, 15, 5], index: [22, 30, 15, 0], others: [22, 30, 15, 0] },
  fist: { thumb: [10, 30, 40, 22], index: CLOSED, others: CLOSED },
  point: { thumb: [10, 30, 40, 22], index: [5, 5, 3, 0], others: CLOSED },
  pinch: { thumb: [10, 20, 30, 15], index: [45, 50, 35, 0], others: [25, 30, 15, 0] },
  "power-grasp": { thumb: [0, 25, 25, 22], index: [50, 45, 25, 0], others: [50, 45, 25, 0] },
};

/** Ends of the grasp slider: fingers ready around something of 5 to 8 cm with the thumb opposed,
 * and closed hard on it. The base joints do most of it, so that the pads come down flat. */
const GRASP: readonly [Shape, Shape] = [
  { thumb: [-14, 2, 2, 22], index: [30, 12, 8, 0], others: [30, 12, 8, 0] },
  { thumb: [18, 22, 25, 22], index: [72, 34, 20, 0], others: [72, 34, 20, 0] },
];

function write(shape: Shape): Angles {
  const angles = new Float64Array(ANGLE_COUNT);
  for (let digit = 0; digit < DIGIT_COUNT; digit++) {
    const [base, second, third, spread] =
      digit === 0 ? shape.thumb : digit === 1 ? shape.index : shape.others;
    // The middle finger's spread is towards the thumb: it stays.
    const across = digit === 2 ? 0 : spread;
    [base, across, second, third].forEach((degrees, k) => {
      angles[4 * digit + k] = (degrees * Math.PI) / 180;
    });
  }
  return angles;
}

/** Thumb that lets fingers pass, base flexion, base spread, second and third flexion, degrees. */
const THUMB_ASIDE = [-10, 22, 0, 0];

/** A shape of any hand. */
export function preset(name: Preset): Angles {
  return write(SHAPES[name]);
}

/** A shape of this hand: its own where the server knows one. */
export function presetOf(name: Preset, hand: HandModel): Angles {
  return hand.shapes.get(name)?.slice() ?? preset(name);
}

/** True for shapes with the thumb over bent fingers, which bend before it. */
export const thumbLast = (name: Preset): boolean => name === "fist" || name === "point";

/** Angles of a closed shape with the thumb still aside. */
export function thumbAside(angles: Angles): Angles {
  const aside = angles.slice();
  aside.set(THUMB_ASIDE.map((degrees) => (degrees * Math.PI) / 180));
  return aside;
}

/** Fingers this near are there, rad. */
const FINGERS_THERE = 0.1;

/** Part of the way to or from a closed shape during which fingers bend and the thumb is aside. */
const THUMB_LAST = 0.75;

/** Angles on the way from one shape to another, 0 to 1; the thumb goes aside where fingers pass. */
export function between(from: Preset, to: Preset, share: number, hand: HandModel): Angles {
  const [a, b] = [presetOf(from, hand), presetOf(to, hand)];
  const angles = mix(a, b, share);
  if (from === to || !(thumbLast(from) || thumbLast(to))) return angles;
  // Where the thumb comes aside, and where it leaves from there.
  const off = thumbLast(from) ? 1 - THUMB_LAST : THUMB_LAST;
  const on = thumbLast(to) ? THUMB_LAST : 1 - THUMB_LAST;
  const aside = thumbAside(b);
  if (share < off) angles.set(mix(a, aside, share / off).subarray(0, 4));
  else if (share < on) angles.set(aside.subarray(0, 4));
  else angles.set(mix(aside, b, (share - on) / (1 - on)).subarray(0, 4));
  return angles;
}

/** True when all fingers are within some degrees of their goal. */
export function fingersAre(angles: Angles, goal: Angles): boolean {
  return angles.every((angle, i) => i < 4 || Math.abs(angle - goal[i]) < FINGERS_THERE);
}

const mix = (a: Angles, b: Angles, share: number): Angles => a.map((x, i) => x + (b[i] - x) * share);

/** The grasp slider's shape: 0 about to grasp, 1 squeezing. */
export function grasp(amount: number): Angles {
  return mix(write(GRASP[0]), write(GRASP[1]), clampShare(amount));
}

/** One digit's shape, straight (0) to closed (1), as four angles. */
export function curl(digit: number, amount: number): Angles {
  const all = mix(write(SHAPES.open), write(SHAPES.fist), clampShare(amount));
  return all.slice(4 * digit, 4 * digit + 4);
}

function clampShare(share: number): number {
  return Math.min(1, Math.max(0, share));
}

/** How closed a digit is, 0 straight to 1 closed, from its three flexions. */
export function curlOf(digit: number, angles: Angles): number {
  return shareAlong(curl(digit, 0), curl(digit, 1), angles.slice(4 * digit, 4 * digit + 4), [0, 2, 3]);
}

/** How far along the grasp slider a pose is, judged by the fingers. */
export function graspOf(angles: Angles): number {
  const flexions = [4, 8, 12, 16].flatMap((start) => [start, start + 2, start + 3]);
  return shareAlong(grasp(0), grasp(1), angles, flexions);
}

/** Least squares: the share of the way from `a` to `b` that comes closest, over some angles. */
function shareAlong(a: Angles, b: Angles, angles: Angles, of: readonly number[]): number {
  let [along, length] = [0, 0];
  for (const i of of) {
    along += (angles[i] - a[i]) * (b[i] - a[i]);
    length += (b[i] - a[i]) ** 2;
  }
  return clampShare(along / length);
}

/** Largest spread of the slider, rad; it moves index, ring and little apart. */
export const SPREAD_MOST = (18 * Math.PI) / 180;
const SPREADING = [5, 13, 17];

/** The fingers' spread as a share of the most, -1 crossing to 1 wide. */
export function spreadOf(angles: Angles): number {
  const mean = SPREADING.reduce((sum, i) => sum + angles[i], 0) / SPREADING.length;
  return Math.min(1, Math.max(-1, mean / SPREAD_MOST));
}

export function setSpread(angles: Angles, share: number): void {
  for (const i of SPREADING) angles[i] = share * SPREAD_MOST;
}

/** Keeps angles within what the hand's joints allow; a joint the hand lacks is at 0. */
export function clampAngles(angles: Angles, hand: HandModel): Angles {
  return angles.map((angle, i) => {
    const joint = hand.angles[i];
    if (joint === null) return 0;
    return Number.isFinite(angle) ? Math.min(joint.max, Math.max(joint.min, angle)) : joint.rest;
  });
}

export function restAngles(hand: HandModel): Angles {
  return Float64Array.from(hand.angles, (joint) => joint?.rest ?? 0);
}
