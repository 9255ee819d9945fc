// Both hands of an XR frame, read with one call each for poses and radii, into arrays that stay.

import { JOINTS, newHandJoints, type HandJoints } from "../tracking/joints";
import { packJoints } from "../tracking/pack";
import { moveJoints, type Rigid } from "../tracking/rigid";
import type { Side } from "../protocol/types";
import { SIDES } from "../tracking/outlet";

/** A hand not seen for this long is lost, s: trackers drop single frames. */
export const LOST_AFTER_S = 0.1;

interface Tracked {
  spaces: XRJointSpace[];
  source: XRHand | null;
  readonly matrices: Float32Array;
  readonly radii: Float32Array;
  /** In the simulated world. */
  readonly joints: HandJoints;
  /** When it was last seen, s. */
  seen: number;
  /** Seen in this very frame. */
  fresh: boolean;
}

const tracked = (): Tracked => ({
  spaces: [],
  source: null,
  matrices: new Float32Array(16 * JOINTS),
  radii: new Float32Array(JOINTS),
  joints: newHandJoints(),
  seen: -Infinity,
  fresh: false,
});

export class XrHands {
  private readonly hands: Record<Side, Tracked> = { left: tracked(), right: tracked() };

  /** Reads what the frame knows. `toWorld` takes the reference space to the simulated world. */
  read(frame: XRFrame, space: XRReferenceSpace, toWorld: Rigid, time: number): void {
    for (const side of SIDES) this.hands[side].fresh = false;
    // While something else has the visitor's attention, hands are not the page's to read.
    if (frame.session.visibilityState !== "visible") return;
    for (const source of frame.session.inputSources) {
      const { hand, handedness } = source;
      if (!hand || handedness === "none") continue;
      const into = this.hands[handedness];
      if (into.source !== hand) {
        into.source = hand;
        into.spaces = [...hand.values()];
      }
      if (into.fresh || into.spaces.length !== JOINTS) continue;
      if (!fillPoses(frame, space, into) || !packJoints(into.matrices, into.radii, into.joints)) continue;
      moveJoints(into.joints, toWorld);
      into.seen = time;
      into.fresh = true;
    }
  }

  /** The hand as of this frame, or null. */
  fresh(side: Side): HandJoints | null {
    const hand = this.hands[side];
    return hand.fresh ? hand.joints : null;
  }

  lost(side: Side, time: number): boolean {
    return time - this.hands[side].seen > LOST_AFTER_S;
  }

  forget(): void {
    for (const side of SIDES) {
      const hand = this.hands[side];
      hand.source = null;
      hand.seen = -Infinity;
      hand.fresh = false;
    }
  }
}

function fillPoses(frame: XRFrame, space: XRReferenceSpace, into: Tracked): boolean {
  if (frame.fillPoses === undefined || frame.fillJointRadii === undefined) return false;
  return (
    frame.fillPoses(into.spaces, space, into.matrices) &&
    frame.fillJointRadii(into.spaces, into.radii)
  );
}
