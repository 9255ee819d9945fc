// Page and tracking thread, wired to each other without a thread: questions are answered, and failures have reasons.

import { describe, expect, it } from "vitest";
import type { FromTracker, ToTracker, TrackedHand } from "../../src/tracking/hand-messages";
import { serveTracker, type Look } from "../../src/tracking/hand-service";
import { HandTracker, HandTrackerOnce, type TrackerThread } from "../../src/tracking/hand-tracker";

const HAND: TrackedHand = { side: "left", score: 0.9, picture: [{ x: 0.1, y: 0.2, z: 0 }], metres: [{ x: 0, y: 0, z: 0.01 }] };

class Picture {
  closed = 0;
  close(): void {
    this.closed += 1;
  }
  get bitmap(): ImageBitmap {
    return this as unknown as ImageBitmap;
  }
}

/** A thread that answers in its own time, as a real one does; messages are copied but for what is handed over. */
class Thread implements TrackerThread {
  onmessage: TrackerThread["onmessage"] = null;
  onerror: TrackerThread["onerror"] = null;
  ended = 0;
  readonly handedOver: Transferable[] = [];
  private readonly serve: (message: ToTracker) => Promise<void>;

  constructor(open: (folder: string) => Promise<Look>) {
    this.serve = serveTracker(open, (message: FromTracker) => {
      const data = structuredClone(message);
      if (this.ended === 0) this.onmessage?.({ data } as MessageEvent<FromTracker>);
    });
  }

  postMessage(message: ToTracker, transfer: Transferable[]): void {
    this.handedOver.push(...transfer);
    queueMicrotask(() => void this.serve(message));
  }

  terminate(): void {
    this.ended += 1;
  }
}

describe("the hand tracker", () => {
  it("loads from the folder it is given, and finds hands in pictures that it closes", async () => {
    const seen: unknown[] = [];
    const thread = new Thread(async (folder) => {
      seen.push(folder);
      return (_, time) => {
        seen.push(time);
        return [HAND];
      };
    });
    const tracker = await HandTracker.load("https://page/mediapipe/", thread);
    const [one, two] = [new Picture(), new Picture()];
    expect(await tracker.look(one.bitmap, 5)).toEqual([HAND]);
    expect(await tracker.look(two.bitmap, 21)).toEqual([HAND]);
    expect(seen).toEqual(["https://page/mediapipe/", 5, 21]);
    expect([one.closed, two.closed]).toEqual([1, 1]);
    expect(thread.handedOver).toEqual([one, two]);
  });

  it("says why it did not load, and ends its thread", async () => {
    const thread = new Thread(() => Promise.reject(new Error("no SIMD")));
    await expect(HandTracker.load("/", thread)).rejects.toThrow("The hand tracker did not load: no SIMD");
    expect(thread.ended).toBe(1);
  });

  it("says that the thread itself did not start", async () => {
    const thread = new Thread(() => new Promise(() => undefined));
    const loading = HandTracker.load("/", thread);
    thread.onerror?.({ message: "" } as ErrorEvent);
    await expect(loading).rejects.toThrow("its thread did not start");
  });

  it("is of no more use once it broke over a picture, which is closed all the same", async () => {
    const thread = new Thread(async () => () => {
      throw new Error("out of memory");
    });
    const tracker = await HandTracker.load("/", thread);
    const [one, two] = [new Picture(), new Picture()];
    await expect(tracker.look(one.bitmap, 1)).rejects.toThrow("out of memory");
    await expect(tracker.look(two.bitmap, 2)).rejects.toThrow("out of memory");
    expect([one.closed, two.closed, thread.ended]).toEqual([1, 1, 1]);
  });

  it("looks at one picture at a time, and answers who waits when it is closed", async () => {
    const tracker = await HandTracker.load("/", new Thread(async () => () => []));
    const [one, two] = [new Picture(), new Picture()];
    const first = tracker.look(one.bitmap, 1);
    await expect(tracker.look(two.bitmap, 2)).rejects.toThrow("still looking");
    expect(two.closed).toBe(1);
    expect(await first).toEqual([]);
    const waiting = tracker.look(new Picture().bitmap, 3);
    tracker.close();
    await expect(waiting).rejects.toThrow("it was closed");
  });

  it("refuses pictures before it is loaded", async () => {
    const answers: FromTracker[] = [];
    const serve = serveTracker(async () => () => [], (message) => answers.push(message));
    const picture = new Picture();
    await serve({ type: "picture", picture: picture.bitmap, time: 0 });
    expect(answers).toEqual([{ type: "failed", reason: "it is not loaded" }]);
    expect(picture.closed).toBe(1);
  });

  it("is loaded once by all who ask while it loads, and anew after it failed or was dropped", async () => {
    const threads: Thread[] = [];
    const ends: (() => void)[] = [];
    const once = new HandTrackerOnce(() => {
      const thread = new Thread(() => new Promise((done, fail) => ends.push(threads.length === 1 ? () => fail(new Error("no")) : () => done(() => []))));
      threads.push(thread);
      return HandTracker.load("/", thread);
    });
    const next = async () => {
      await new Promise((resolve) => setTimeout(resolve));
      ends.shift()!();
    };
    const [one, two] = [once.get(), once.get()];
    void next();
    await expect(one).rejects.toThrow("no");
    await expect(two).rejects.toThrow("no");
    expect(threads.map((thread) => thread.ended)).toEqual([1]);
    // Off and on again before it is there.
    const [three, four] = [once.get(), once.get()];
    void next();
    expect(await three).toBe(await four);
    expect(threads.map((thread) => thread.ended)).toEqual([1, 0]);
    once.drop();
    const five = once.get();
    void next();
    expect(await five).not.toBe(await three);
    expect(threads.map((thread) => thread.ended)).toEqual([1, 1, 0]);
  });
});
