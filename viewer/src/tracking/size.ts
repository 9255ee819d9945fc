// How large the wearer's hand is, relative to the model's, from tracked joints and radii.
//
// Lengths are taken along the bones, from wrist to fingertip, so the pose of the hand does not
// matter; of all that trackers report they agree best (knuckles are placed differently). Widths are
// joint radii against half the width of the model's mesh there. The two are averaged by how far
// they are to be trusted: a length is good to 2 %, a radius to 10 %, so widths have about a tenth
// of the say. The server scales a hand as a whole, by its length only: fingers thick for their
// length are reported as `thickness`, not imitated.

import { DIGIT_JOINTS, jointDistance, jointRadius, type HandJoints } from "./joints";

/** Wrist to the skin of the middle fingertip of the model at scale 1 (crates/thenar-rig/assets/hands), m. */
export const MODEL_LENGTH = 0.1893;
/** Wrist to first knuckle and on along the bones to the skin of the tip, thumb first, m; measured
 * on the meshes of crates/thenar-rig/assets/hands. WebXR's tips are at the skin too. */
const MODEL_CHAINS = [0.1399, 0.1836, 0.19, 0.1788, 0.1586];
/** Half the width of the mesh across the joints after the first knuckle, per digit, m. */
const MODEL_WIDTHS = [
  [0.01, 0.0086],
  [0.0083, 0.0073, 0.0069],
  [0.0085, 0.0077, 0.0074],
  [0.0077, 0.0071, 0.0069],
  [0.007, 0.0063, 0.0059],
];
const CHAIN_WEIGHT = 1 / 0.02 ** 2;
const WIDTH_WEIGHT = 1 / 0.1 ** 2;
/** Relative thickness beyond which radii are not believed. */
const THICKNESS_RANGE = [0.6, 1.6];
/** Hands from a small child's to a very large man's, m; other lengths are not believed. */
export const LENGTH_RANGE = [0.1, 0.26] as const;

export interface HandSize {
  /** Wrist to middle fingertip, m, as the server's `hands` command takes it. */
  readonly length: number;
  /** Widths over lengths, relative to the model: 1.1 means 10 % thicker fingers. */
  readonly thickness: number;
  /** Whether the radii were believed. */
  readonly usedRadii: boolean;
}

/** The size that one frame shows, or null if it cannot be a hand. */
export function sizeOf(hand: HandJoints): HandSize | null {
  let [chains, widths, widthCount] = [0, 0, 0];
  DIGIT_JOINTS.forEach((joints, digit) => {
    const [, knuckle, ...rest] = joints;
    let chain = jointDistance(hand, 0, knuckle);
    rest.forEach((joint, i) => {
      chain += jointDistance(hand, joint, i === 0 ? knuckle : rest[i - 1]);
      widths += jointRadius(hand, joint) / MODEL_WIDTHS[digit][i];
      widthCount += 1;
    });
    chains += chain / MODEL_CHAINS[digit];
  });
  const byLength = chains / DIGIT_JOINTS.length;
  const thickness = widths / widthCount / byLength;
  const usedRadii = thickness > THICKNESS_RANGE[0] && thickness < THICKNESS_RANGE[1];
  const widthWeight = usedRadii ? WIDTH_WEIGHT * widthCount : 0;
  const chainWeight = CHAIN_WEIGHT * DIGIT_JOINTS.length;
  const scale =
    (byLength * chainWeight + byLength * thickness * widthWeight) / (chainWeight + widthWeight);
  const length = scale * MODEL_LENGTH;
  if (!(length >= LENGTH_RANGE[0] && length <= LENGTH_RANGE[1])) return null;
  return { length, thickness, usedRadii };
}

/** Frames wanted before the median is believed, and the time they must span, s. */
const FRAMES_MIN = 20;
const SPAN_MIN = 1;
const FRAMES_MOST = 240;

/** Collects sizes of one hand until their median is worth using. */
export class SizeMedian {
  private sizes: HandSize[] = [];
  private first = 0;
  private last = 0;

  /** `time` in seconds. */
  add(hand: HandJoints, time: number): void {
    const size = sizeOf(hand);
    if (size === null || this.sizes.length >= FRAMES_MOST) return;
    if (this.sizes.length === 0) this.first = time;
    this.last = time;
    this.sizes.push(size);
  }

  /** The frame of median length, or null while there is too little. */
  get(): HandSize | null {
    if (this.sizes.length < FRAMES_MIN || this.last - this.first < SPAN_MIN) return null;
    const sorted = [...this.sizes].sort((a, b) => a.length - b.length);
    return sorted[Math.floor(sorted.length / 2)];
  }
}
