// Which of the scene's hands the visitor leads, and what they are called.

import type { HandModel, Side } from "../protocol/types";
import { HANDS_MOST } from "./quantities";

/** Indices of the hands to show: all of the sides that are led, for a pose moves every hand of its side; while none is, those
 * of before, or the scene's first. */
export function ledHands(hands: readonly HandModel[], led: readonly Side[], before: readonly number[]): number[] {
  const now = hands.flatMap(({ side }, i) => (side !== null && led.includes(side) ? [i] : []));
  const kept = before.filter((i) => i < hands.length);
  const first = hands.length > 0 ? [0] : [];
  return [now, kept, first].find((some) => some.length > 0)?.slice(0, HANDS_MOST) ?? [];
}

/** "Left hand", or with its own name where that says more; its own name where its side is not known. */
export function handName({ name, side }: HandModel): string {
  if (side === null) return name;
  const words = `${side[0].toUpperCase()}${side.slice(1)} hand`;
  return ["hand", side, `${side} hand`].includes(name) ? words : `${words}: ${name}`;
}
