// Brings the page to the view its address asks for.

import type { App } from "../app";
import { LAYERS } from "../scene/layers";
import { PauseAt } from "./pause-at";
import type { ViewLink } from "./view-link";

/** Asked again for a scene the server did not go to, at most so often. */
const ASK_MOST = 3;

export function openLink(app: App, link: ViewLink, told: (message: string) => void): void {
  const { connection, feed, stage } = app;
  if (link.layers !== null) for (const layer of LAYERS) stage.setLayer(layer, link.layers.includes(layer));
  let pauseAt = link.pauseAt === null ? null : new PauseAt(link.pauseAt);
  let asked = 0;
  let placed = link.camera === null;

  const arrived = () => link.scene === null || feed.model?.scene === link.scene;
  connection.on("status", ({ scene, loading }) => {
    if (link.scene === null || scene === link.scene || loading !== null) return;
    if (arrived() || asked >= ASK_MOST || asked < 0) return;
    if (!connection.inControl) {
      told(`This link shows ${link.scene}; whoever holds control shows ${scene}.`);
      asked = -1;
      return;
    }
    if (!(connection.welcome?.scenes ?? []).some(({ name }) => name === link.scene)) {
      told(`There is no scene "${link.scene}" here.`);
      asked = -1;
      return;
    }
    asked += 1;
    connection.send({ type: "scene", name: link.scene });
  });
  // The stage sets the scene's own camera with the model; this listener comes after it.
  feed.on("model", () => {
    if (placed || !arrived() || link.camera === null) return;
    placed = true;
    if (typeof link.camera === "string") {
      stage.setView(link.camera);
      return;
    }
    stage.camera.position.set(...link.camera.position);
    stage.controls.target.set(...link.camera.target);
    stage.controls.update();
  });
  connection.on("snapshot", (snapshot) => {
    if (pauseAt === null || !arrived() || !connection.inControl || connection.model === null) return;
    const moment = {
      time: snapshot.time,
      paused: (snapshot.flags & 1) !== 0,
      step: connection.model.time_step,
      now: performance.now(),
    };
    const command = pauseAt.next(moment);
    if (command !== null) connection.send(command);
    if (pauseAt.done) {
      pauseAt = null;
      document.documentElement.dataset["moment"] = "reached";
    }
  });
  // Someone who touches the run takes over from the link.
  document.querySelector(".transport")?.addEventListener("click", () => (pauseAt = null));
}
