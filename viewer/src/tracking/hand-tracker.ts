// The page's side of the thread that looks at pictures. It is loaded when somebody asks for the webcam.

import type { FromTracker, ToTracker, TrackedHand } from "./hand-messages";

/** As much of a Worker as is used. */
export interface TrackerThread {
  postMessage(message: ToTracker, transfer: Transferable[]): void;
  terminate(): void;
  onmessage: ((event: MessageEvent<FromTracker>) => void) | null;
  onerror: ((event: ErrorEvent) => void) | null;
}

interface Asked {
  readonly done: (message: FromTracker) => void;
  readonly fail: (error: Error) => void;
}

export class HandTracker {
  private asked: Asked | null = null;
  private over: string | null = null;

  private constructor(private readonly thread: TrackerThread) {
    thread.onmessage = ({ data }) => {
      if (data.type === "failed") this.end(data.reason);
      else this.take()?.done(data);
    };
    thread.onerror = ({ message }) => this.end(message || "its thread did not start");
  }

  /** A tracker of up to two hands, ready for pictures. `folder`: address of its files. */
  static async load(folder: string, thread: TrackerThread = startThread()): Promise<HandTracker> {
    const tracker = new HandTracker(thread);
    try {
      await tracker.ask({ type: "load", folder }, []);
    } catch (error) {
      throw new Error(`The hand tracker did not load: ${error instanceof Error ? error.message : String(error)}`);
    }
    return tracker;
  }

  /** The hands in a picture, which is handed over. One picture at a time. */
  async look(picture: ImageBitmap, time: number): Promise<readonly TrackedHand[]> {
    const answer = await this.ask({ type: "picture", picture, time }, [picture]);
    return answer.type === "hands" ? answer.hands : [];
  }

  close(): void {
    this.end("it was closed");
  }

  private ask(message: ToTracker, transfer: Transferable[]): Promise<FromTracker> {
    return new Promise((done, fail) => {
      const refused = this.over ?? (this.asked === null ? null : "it is still looking at a picture");
      if (refused !== null) {
        if (message.type === "picture") message.picture.close();
        return fail(new Error(refused));
      }
      this.asked = { done, fail };
      this.thread.postMessage(message, transfer);
    });
  }

  private take(): Asked | null {
    const { asked } = this;
    this.asked = null;
    return asked;
  }

  private end(reason: string): void {
    this.over ??= reason;
    this.thread.terminate();
    this.take()?.fail(new Error(reason));
  }
}

/** A tracker that is loaded when first asked for, once however often that is; anew after it failed or was dropped. */
export class HandTrackerOnce {
  private loading: Promise<HandTracker> | null = null;

  constructor(private readonly load: () => Promise<HandTracker>) {}

  get(): Promise<HandTracker> {
    const loading = (this.loading ??= this.load());
    loading.catch(() => {
      if (this.loading === loading) this.loading = null;
    });
    return loading;
  }

  drop(): void {
    this.loading?.then(
      (tracker) => tracker.close(),
      () => undefined,
    );
    this.loading = null;
  }
}

function startThread(): TrackerThread {
  return new Worker(new URL("./hand-worker.ts", import.meta.url), { type: "module", name: "hands" });
}
