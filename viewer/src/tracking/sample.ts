// A recorded track at any time, between its samples, and where it is put into the scene.

import { Quaternion, Vector3 } from "three";
import { JOINTS, JOINT_NUMBERS, type HandJoints } from "./joints";
import type { Motion, Track } from "./motion";
import type { Rigid } from "./rigid";

/** A longer gap between samples is a loss of tracking, s. */
export const LOSS_S = 0.1;

const a = new Quaternion();
const b = new Quaternion();

/** The hand at `time`, or false before, after and within a loss. */
export function sampleTrack(track: Track, time: number, out: HandJoints): boolean {
  const next = firstAfter(track.times, time);
  if (next === 0) return false;
  const before = track.samples[next - 1];
  if (next === track.times.length) {
    if (time > track.times[next - 1]) return false;
    out.set(before);
    return true;
  }
  const [t0, t1] = [track.times[next - 1], track.times[next]];
  if (t1 - t0 > LOSS_S) {
    if (time > t0) return false;
    out.set(before);
    return true;
  }
  blend(before, track.samples[next], (time - t0) / (t1 - t0), out);
  return true;
}

/** Straight lines between positions, shortest arcs between rotations. */
function blend(from: Float32Array, to: Float32Array, share: number, out: HandJoints): void {
  for (let i = 0; i < out.length; i++) out[i] = from[i] + share * (to[i] - from[i]);
  for (let joint = 0; joint < JOINTS; joint++) {
    const at = JOINT_NUMBERS * joint + 3;
    a.fromArray(from, at).slerp(b.fromArray(to, at), share).toArray(out, at);
  }
}

/** Index of the first time later than `time`. */
function firstAfter(times: readonly number[], time: number): number {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Where the hands begin: above the middle of the scene and a little towards the visitor, m. */
const BEGIN = new Vector3(0, 0.15, 0.1);

/** Takes the recording's space to the world: level and unturned, shifted so that the first wrist
 * (of two hands, the middle of both) is above `centre` and no joint ever below the table, y = 0. */
export function placeMotion(motion: Motion, centre: Vector3): Rigid {
  const first = new Vector3();
  const tracks = [motion.tracks.left, motion.tracks.right].filter((track) => track !== undefined);
  let lowest = Infinity;
  for (const track of tracks) {
    first.addScaledVector(new Vector3().fromArray(track.samples[0]), 1 / tracks.length);
    for (const sample of track.samples) {
      for (let at = 1; at < sample.length; at += JOINT_NUMBERS) lowest = Math.min(lowest, sample[at]);
    }
  }
  const position = new Vector3(centre.x, 0, centre.z).add(BEGIN).sub(first);
  position.y = Math.max(position.y, -lowest);
  return { position, rotation: new Quaternion() };
}
