// What the page shows: the live simulation, or a recording in its place. The stage and the plots
// listen here and need not know which it is.

import type { Connection } from "./net/connection";
import { Emitter } from "./net/events";
import type { SceneModel, Snapshot } from "./protocol/types";

export interface FeedEvents {
  model: SceneModel;
  snapshot: Snapshot;
  /** Live again, or not any more. */
  live: boolean;
}

export class Feed extends Emitter<FeedEvents> {
  model: SceneModel | null = null;
  snapshot: Snapshot | null = null;
  live = true;

  constructor(private readonly connection: Connection) {
    super();
    connection.on("model", (model) => {
      if (this.live) this.setModel(model);
    });
    connection.on("snapshot", (snapshot) => {
      if (this.live) this.setSnapshot(snapshot);
    });
  }

  /** Shows a recorded moment instead of the live one. */
  showRecorded(model: SceneModel, snapshot: Snapshot): void {
    if (this.live) {
      this.live = false;
      this.emit("live", false);
    }
    if (this.model !== model) this.setModel(model);
    this.setSnapshot(snapshot);
  }

  backToLive(): void {
    if (this.live) return;
    this.live = true;
    this.emit("live", true);
    const { model, snapshot } = this.connection;
    if (model !== null) this.setModel(model);
    if (snapshot !== null) this.setSnapshot(snapshot);
  }

  private setModel(model: SceneModel): void {
    this.model = model;
    this.snapshot = null;
    this.emit("model", model);
  }

  private setSnapshot(snapshot: Snapshot): void {
    this.snapshot = snapshot;
    this.emit("snapshot", snapshot);
  }
}
