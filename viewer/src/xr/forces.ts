// Forces of the newest snapshot as XR shows them.

import { DIGITS, PER_DIGIT, PER_HAND, type SceneModel, type Side, type Snapshot } from "../protocol/types";

/** Normal force per digit, palm first, N; null if the scene lacks this hand. */
export function digitForces(model: SceneModel, snapshot: Snapshot, side: Side): number[] | null {
  const hand = model.hands.findIndex((candidate) => candidate.side === side);
  if (hand < 0) return null;
  return DIGITS.map((_, digit) => snapshot.fingers[PER_HAND * hand + PER_DIGIT * digit] ?? 0);
}

export function totalForce(model: SceneModel | null, snapshot: Snapshot | null, side: Side): number {
  if (model === null || snapshot === null) return 0;
  return digitForces(model, snapshot, side)?.reduce((sum, force) => sum + force, 0) ?? 0;
}

/** Force at which colour and vibration are full, N: a firm press of one finger. */
export const FORCE_FULL = 6;

/** 0 to 1, rising fast at first: light touches are to be told apart. */
export function forceShare(force: number): number {
  return Math.sqrt(Math.min(1, Math.max(0, force / FORCE_FULL)));
}
