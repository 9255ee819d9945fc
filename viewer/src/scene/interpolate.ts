// What to show between two snapshots. The page shows the way from the last but one snapshot to the
// last while waiting for the next: motion is smooth at any rate of the screen, and late by one
// snapshot at most. Switched off, the newest snapshot shows as it is.

import type { SceneModel, Snapshot } from "../protocol/types";

/** Longer pauses between snapshots are not bridged, ms. */
const LONGEST = 80;

export class Interpolator {
  on = true;
  readonly rigids: Float32Array;
  readonly nodes: Float32Array;
  readonly targets: Float32Array;
  private before: Snapshot | null = null;
  private newest: Snapshot | null = null;
  /** Running mean of the time between snapshots, ms. */
  private interval = 16;
  private shown = -1;

  constructor(model: SceneModel) {
    this.rigids = new Float32Array(7 * model.rigids.length);
    this.nodes = new Float32Array(3 * model.node_count);
    this.targets = new Float32Array(7 * model.target_count).fill(NaN);
  }

  push(snapshot: Snapshot): void {
    const last = this.newest;
    // Neither a reset nor a long pause is a motion.
    const pause = last === null ? Infinity : snapshot.received - last.received;
    const goesOn = last !== null && snapshot.time >= last.time && pause < 4 * LONGEST;
    if (goesOn && pause < LONGEST) this.interval += 0.1 * (pause - this.interval);
    this.before = goesOn ? last : null;
    this.newest = snapshot;
    this.shown = -1;
  }

  /** Fills the arrays for the moment `now`, ms. False if nothing changed since the last call. */
  update(now: number): boolean {
    const { before, newest } = this;
    if (newest === null) return false;
    let part = 1;
    if (this.on && before !== null) {
      part = Math.min(1, Math.max(0, (now - newest.received) / Math.max(1, this.interval)));
    }
    if (part === this.shown) return false;
    this.shown = part;
    if (before === null || part === 1) {
      this.rigids.set(newest.rigids);
      this.nodes.set(newest.nodes);
      this.targets.set(newest.targets);
      return true;
    }
    blend(before.nodes, newest.nodes, part, this.nodes);
    blendPoses(before.rigids, newest.rigids, part, this.rigids);
    blendPoses(before.targets, newest.targets, part, this.targets);
    return true;
  }
}

function blend(a: Float32Array, b: Float32Array, part: number, out: Float32Array): void {
  for (let i = 0; i < out.length; i++) out[i] = a[i] + part * (b[i] - a[i]);
}

/** Positions in a straight line, quaternions along the shorter way. */
export function blendPoses(a: Float32Array, b: Float32Array, part: number, out: Float32Array): void {
  for (let i = 0; i < out.length; i += 7) {
    for (let c = 0; c < 3; c++) out[i + c] = a[i + c] + part * (b[i + c] - a[i + c]);
    let dot = 0;
    for (let c = 3; c < 7; c++) dot += a[i + c] * b[i + c];
    const sign = dot < 0 ? -1 : 1;
    let square = 0;
    for (let c = 3; c < 7; c++) {
      const q = (1 - part) * sign * a[i + c] + part * b[i + c];
      out[i + c] = q;
      square += q * q;
    }
    const scale = 1 / Math.sqrt(square);
    for (let c = 3; c < 7; c++) out[i + c] *= scale;
  }
}
