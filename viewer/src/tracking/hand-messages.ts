// What the page and the thread that looks at pictures tell each other.

import type { Side } from "../protocol/types";
import type { Point } from "./webcam-hand";

/** A hand in one picture. */
export interface TrackedHand {
  readonly side: Side;
  /** How sure it is of that, 0 to 1. */
  readonly score: number;
  /** 21 points in the picture, 0 to 1, y down; and in metres about the hand's middle. */
  readonly picture: readonly Point[];
  readonly metres: readonly Point[];
}

export type ToTracker =
  /** Address of the tracker's files, with a slash at its end. */
  | { readonly type: "load"; readonly folder: string }
  /** Handed over with the message; `time`, ms, grows from one to the next. */
  | { readonly type: "picture"; readonly picture: ImageBitmap; readonly time: number };

export type FromTracker =
  | { readonly type: "ready" }
  /** Answers one picture. */
  | { readonly type: "hands"; readonly hands: readonly TrackedHand[] }
  /** Loading or looking failed; the tracker is of no more use. */
  | { readonly type: "failed"; readonly reason: string };
