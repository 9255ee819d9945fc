// Brings the page to the view its address asks for.

import type { App } from "../app";
import { LAYERS } from "../scene/layers";
import { TAKE_CONTROL, takeControl, type Desk } from "./desk";
import { PauseAt } from "./pause-at";
import type { ViewLink } from "./view-link";

/** Asked again for a scene the server did not go to, at most so often. */
const ASK_MOST = 3;

export function openLink(desk: Desk, link: ViewLink): void {
  const { app } = desk;
  const { connection, feed, stage } = app;
  // A link that cannot be followed says so on a bare picture, too.
  const told = (message: string) => desk.toasts.show(message, "warning", null, true);
  const toldWatching = (message: string) =>
    desk.toasts.show(message, "warning", { label: TAKE_CONTROL, act: () => takeControl(desk) }, true);
  if (link.layers !== null) for (const layer of LAYERS) stage.setLayer(layer, link.layers.includes(layer));
  if (link.weights !== null) {
    stage.setWeightBones(link.weights);
    if (link.layers === null) stage.setLayer("weights", true);
  }
  let pauseAt = link.pauseAt === null ? null : new PauseAt(link.pauseAt);
  let asked = 0;
  let complained = false;
  let placed = link.camera === null;

  const arrived = () => link.scene === null || feed.model?.scene === link.scene;
  // Whoever goes to another scene later is not called back.
  let been = arrived();
  feed.on("model", () => (been ||= arrived()));
  connection.on("status", ({ scene, loading }) => {
    if (been || link.scene === null || scene === link.scene || loading !== null) return;
    if (asked >= ASK_MOST) return;
    // Control may still come: the viewer that held it may just be leaving.
    if (!connection.inControl) {
      if (!complained) toldWatching(`This link shows ${link.scene}; whoever holds control shows ${scene}.`);
      complained = true;
      return;
    }
    if (!(connection.welcome?.scenes ?? []).some(({ name }) => name === link.scene)) {
      told(`There is no scene "${link.scene}" here.`);
      asked = ASK_MOST;
      return;
    }
    asked += 1;
    connection.send({ type: "scene", name: link.scene });
  });
  // The stage frames a new scene when it first draws it: the link's camera comes after that.
  let frames = 0;
  const placing = stage.onFrame(() => {
    if (placed || !arrived() || stage.snapshot === null) return;
    frames += 1;
    if (frames < 3) return;
    placed = true;
    placing();
    place(app, link);
  });
  const approach = () => {
    const { snapshot, model } = connection;
    if (been && !arrived()) pauseAt = null;
    if (pauseAt === null || snapshot === null || model === null || !arrived() || !connection.inControl) return;
    const moment = {
      time: snapshot.time,
      paused: (snapshot.flags & 1) !== 0,
      step: model.time_step,
      now: performance.now(),
    };
    const command = pauseAt.next(moment);
    if (command !== null) connection.send(command);
    if (!pauseAt.done) return;
    pauseAt = null;
    document.documentElement.dataset["moment"] = "reached";
  };
  connection.on("snapshot", approach);
  // Only who holds control can go to the link's moment.
  connection.on("status", ({ control }) => {
    const held = control !== null && control !== connection.welcome?.client;
    if (pauseAt === null || complained || !held || !arrived()) return;
    complained = true;
    toldWatching(`This link stops at ${link.pauseAt ?? 0} s, but viewer ${control} holds control.`);
  });
  // While paused no snapshot comes: control may have come since, or a command got lost.
  const patience = setInterval(() => (pauseAt === null ? clearInterval(patience) : approach()), 250);
  // Someone who touches the run takes over from the link.
  document.querySelector(".transport")?.addEventListener("click", () => (pauseAt = null));
}

function place({ stage }: App, { camera }: ViewLink): void {
  if (camera === null) return;
  if (typeof camera === "string") {
    stage.setView(camera);
    return;
  }
  stage.placeCamera(camera.position, camera.target, camera.fov);
}
