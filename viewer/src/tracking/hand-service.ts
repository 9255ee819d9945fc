// The tracker's side of the messages, whatever tracks: the thread gives it MediaPipe, tests a made-up one.

import type { FromTracker, ToTracker, TrackedHand } from "./hand-messages";

/** Finds the hands in a picture, taken at a time, ms. */
export type Look = (picture: ImageBitmap, time: number) => TrackedHand[];

/** Answers every message with one of its own. Pictures are closed, come what may. */
export function serveTracker(open: (folder: string) => Promise<Look>, answer: (message: FromTracker) => void) {
  let look: Look | null = null;
  const fail = (error: unknown) => {
    look = null;
    answer({ type: "failed", reason: error instanceof Error ? error.message : String(error) });
  };
  return async (message: ToTracker): Promise<void> => {
    if (message.type === "load") {
      try {
        look = await open(message.folder);
        answer({ type: "ready" });
      } catch (error) {
        fail(error);
      }
      return;
    }
    const { picture, time } = message;
    try {
      if (look === null) throw new Error("it is not loaded");
      answer({ type: "hands", hands: look(picture, time) });
    } catch (error) {
      fail(error);
    } finally {
      picture.close();
    }
  };
}
