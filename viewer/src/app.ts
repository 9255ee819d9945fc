// The parts of the page that others hang on to: one stage, one connection, and how they meet.

import { Feed } from "./feed";
import { InputSources } from "./input/source";
import { Connection, socketUrl, type ConnectionState } from "./net/connection";
import type { SceneModel, Snapshot } from "./protocol/types";
import { Stage } from "./scene/stage";

export interface App {
  readonly stage: Stage;
  readonly connection: Connection;
  /** Live or recorded, what is shown. */
  readonly feed: Feed;
  /** Everything that can move the hand; register a source here and it gets its button. */
  readonly inputs: InputSources;
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
  canvas.after(stage.legend.element);
  const connection = new Connection(socketUrl(window.location));
  const feed = new Feed(connection);
  feed.on("model", (model) => stage.setModel(model));
  feed.on("snapshot", (snapshot) => stage.show(snapshot));
  const inputs = new InputSources({
    get inControl() {
      return connection.inControl;
    },
    get recorded() {
      return (connection.status?.recording ?? null) !== null;
    },
    askControl() {
      if (connection.inControl) return true;
      if (connection.status === null || connection.status.control !== null) return false;
      return connection.send({ type: "control", take: true });
    },
    script: () => void connection.send({ type: "script" }),
  });
  return { stage, connection, feed, inputs };
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
