// The parts of the page that others hang on to: one stage, one connection, and how they meet.

import { Connection, socketUrl, type ConnectionState } from "./net/connection";
import type { SceneModel, Snapshot } from "./protocol/types";
import { Stage } from "./scene/stage";

export interface App {
  readonly stage: Stage;
  readonly connection: Connection;
}

/** `window.thenar`: what the page knows of itself, for tests and the curious. */
export interface PageStatus {
  readonly connection: ConnectionState;
  readonly client: number | null;
  readonly inControl: boolean;
  readonly epoch: number | null;
  readonly snapshotsReceived: number;
  readonly framesDrawn: number;
  readonly model: SceneModel | null;
  readonly snapshot: Snapshot | null;
  readonly fps: number;
  /** CPU cost of one frame, median of 120, ms. */
  readonly frameCost: number;
  readonly bytesPerSecond: number;
  /** Pose sent to snapshot that shows it, median, ms. */
  readonly poseLatency: number | null;
  readonly errors: readonly string[];
  readonly app: App;
}

declare global {
  interface Window {
    thenar: PageStatus;
  }
}

export function createApp(canvas: HTMLCanvasElement): App {
  const stage = new Stage(canvas);
  const connection = new Connection(socketUrl(window.location));
  connection.on("model", (model) => stage.setModel(model));
  connection.on("snapshot", (snapshot) => stage.show(snapshot));
  return { stage, connection };
}

export function publishStatus(app: App): void {
  const { stage, connection } = app;
  const errors: string[] = [];
  connection.on("error", ({ message }) => {
    errors.push(message);
    if (errors.length > 20) errors.shift();
  });
  window.thenar = {
    get connection() {
      return connection.state;
    },
    get client() {
      return connection.welcome?.client ?? null;
    },
    get inControl() {
      return connection.inControl;
    },
    get epoch() {
      return stage.model?.epoch ?? null;
    },
    get snapshotsReceived() {
      return connection.snapshotsReceived;
    },
    get framesDrawn() {
      return stage.stats.frames;
    },
    get model() {
      return stage.model;
    },
    get snapshot() {
      return stage.snapshot;
    },
    get fps() {
      return stage.stats.fps;
    },
    get frameCost() {
      return stage.stats.frameCost;
    },
    get bytesPerSecond() {
      return connection.throughput.bytesPerSecond;
    },
    get poseLatency() {
      return connection.latency.median;
    },
    errors,
    app,
  };
}
