// When to ask for which hands: both as soon as both are known, one if the other stays away. A hand that is seen is
// measured; one that holds a controller is as long as the model's.

import type { Side } from "../protocol/types";
import type { HandJoints } from "../tracking/joints";
import { SIDES, type Lengths } from "../tracking/outlet";
import { SizeMedian, type HandSize } from "../tracking/size";

/** So long the other hand is waited for, s. */
export const WAIT_S = 3;

export class Sizing {
  private readonly medians: Record<Side, SizeMedian> = {
    left: new SizeMedian(),
    right: new SizeMedian(),
  };
  /** Null: as the model is, until it is measured. */
  private readonly found: Partial<Record<Side, HandSize | null>> = {};
  private since: number | null = null;

  add(side: Side, joints: HandJoints, time: number): void {
    if (this.found[side]) return;
    this.medians[side].add(joints, time);
    const size = this.medians[side].get();
    if (size === null) return;
    this.found[side] = size;
    this.since ??= time;
  }

  /** A controller is held on this side. */
  hold(side: Side, time: number): void {
    if (this.found[side] !== undefined) return;
    this.found[side] = null;
    this.since ??= time;
  }

  size(side: Side): HandSize | null {
    return this.found[side] ?? null;
  }

  /** The hands to ask for now, or null while it is better to wait. */
  wanted(time: number): Lengths | null {
    const sides = SIDES.filter((side) => this.found[side] !== undefined);
    const both = sides.length === SIDES.length;
    if (!both && (this.since === null || time - this.since < WAIT_S)) return null;
    return Object.fromEntries(sides.map((side) => [side, this.found[side]?.length ?? null]));
  }
}
