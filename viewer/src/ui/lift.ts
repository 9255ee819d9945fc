// How far the visitor has come in picking up what a scene has to pick up.

import { holdPoint, placeOf, type Thing } from "../input/things";
import { PER_DIGIT, PER_HAND, type SceneModel, type Snapshot } from "../protocol/types";

/** An object that rises this far above the lowest place of the visitor's lead counts as lifted, m. */
const RISE = 0.02;
/** The hand holds what it touches with at least this force, N: a twentieth of the loaf's weight. */
const HELD = 0.05;

/** From here to the middle of the thing a hand that closes gets hold of it, m: half the loaf's length, less a finger. */
const NEAR = 0.05;
/** A thing that was near stays so a little farther, m: the words do not flicker. */
const STILL_NEAR = 0.07;

/** What comes next on the way to a lifted thing. */
export type Step = "take" | "reach" | "close" | "lift";

/** What comes next for a hand that the visitor leads. */
export function nextStep(hand: number, thing: Thing, model: SceneModel, snapshot: Snapshot, before: Step): Step {
  const at = placeOf(thing, snapshot);
  if (at === null) return "close";
  const far = holdPoint(model.hands[hand], snapshot, false).distanceTo(at);
  if (far > (before === "close" || before === "lift" ? STILL_NEAR : NEAR)) return "reach";
  const force = (digit: number) => snapshot.fingers[PER_HAND * hand + PER_DIGIT * digit] ?? 0;
  // Thumb against any finger.
  return force(1) > HELD && [2, 3, 4, 5].some((digit) => force(digit) > HELD) ? "lift" : "close";
}

/** Normal force on all digits of all hands, N. */
function pressing(fingers: Float32Array): number {
  let sum = 0;
  for (let at = 0; at + PER_HAND <= fingers.length; at += PER_HAND) {
    for (let digit = 0; digit < PER_HAND; digit += PER_DIGIT) sum += fingers[at + digit];
  }
  return sum;
}

/** Watches one lead of the visitor from its beginning. */
export class Lift {
  private lowest = Infinity;

  constructor(private readonly thing: Thing) {}

  /** True once the hand holds the thing above its lowest place so far. */
  seen(snapshot: Pick<Snapshot, "nodes" | "rigids" | "fingers">): boolean {
    const height = placeOf(this.thing, snapshot)?.y;
    if (height === undefined) return false;
    this.lowest = Math.min(this.lowest, height);
    return height - this.lowest > RISE && pressing(snapshot.fingers) > HELD;
  }
}
