// Puts the panels, bars and shortcuts around the picture.

import type { App } from "../app";
import { PointerPosing } from "../input/pointer";
import { Posing } from "../input/posing";
import { PosingKeys } from "../input/posing-keys";
import { touchCard } from "../touch/card";
import { banner } from "./banner";
import { keepClear } from "./cover";
import { sayRefused, TAKE_CONTROL, type Desk } from "./desk";
import { h } from "./dom";
import { acceptDrops } from "./drops";
import { graspDock } from "./grasp-dock";
import { helpPanel } from "./help";
import { hint } from "./hint";
import { Keys } from "./keys";
import { openLink } from "./open-link";
import { loading } from "./loading";
import { forcesPanel } from "./panels/forces";
import { inputPanel } from "./panels/input";
import { layersPanel } from "./panels/layers";
import { physicsPanel } from "./panels/physics";
import { picturePanel } from "./panels/picture";
import { recordPanel } from "./panels/record";
import { runPanel } from "./panels/run";
import { posingControls } from "./posing-controls";
import { Shell } from "./shell";
import { Toasts } from "./toasts";
import { transport } from "./transport";
import { parseLink } from "./view-link";

export function mountUi(app: App, root: HTMLElement): Desk {
  const desk: Desk = { app, keys: new Keys(), toasts: new Toasts() };
  const refused = (error: unknown) => sayRefused(desk, error);
  const posing = new Posing(app);
  posing.controls = posingControls(desk, posing);
  app.inputs.register(posing);
  new PointerPosing(app, posing, refused);
  new PosingKeys(app, posing, desk.keys, refused);

  const shell = new Shell();
  const layers = layersPanel(desk);
  const panels = [
    runPanel(desk),
    inputPanel(desk),
    layers,
    forcesPanel(desk),
    physicsPanel(desk),
    recordPanel(desk),
    picturePanel(desk),
    helpPanel(desk),
  ];
  const { top, bottom } = transport(desk);
  for (const panel of panels) shell.add(panel);
  const [next, dock] = [hint(desk, posing), graspDock(desk, posing)];
  const corner = h("section", { class: "corner", "aria-label": "Run and messages" }, desk.toasts.element, next, touchCard(desk), dock, bottom);
  root.append(top, shell.rail, shell.drawer, corner, loading(desk), banner(desk));

  keepClear(app.stage, [next, dock, bottom]);

  let bare = false;
  desk.keys.add({
    key: "u",
    label: "Hide or show everything but the picture",
    group: "Page",
    act: () => shell.hideAll((bare = !bare)),
  });
  app.connection.on("status", () => {
    if (app.connection.inControl) desk.toasts.withdraw(TAKE_CONTROL);
  });
  app.connection.on("error", ({ message }) => desk.toasts.show(message, "error"));
  describe(app);
  acceptDrops((reason) => desk.toasts.show(reason, "warning"));

  const link = parseLink(window.location.hash);
  openLink(desk, link);
  layers.refresh();
  shell.restore(["forces"]);
  bare = !link.ui;
  shell.hideAll(bare);
  // The address is changed by hand or a link is followed: begin anew with it.
  window.addEventListener("hashchange", () => window.location.reload());
  return desk;
}

/** The picture in words, for those who cannot see it. */
function describe({ feed, stage }: App): void {
  feed.on("model", (model) => {
    const bodies = [
      ...model.hands,
      ...model.rigids.filter((r) => r.kind !== "bone"),
      ...model.softs.filter((s) => s.hand === null),
    ];
    const names = bodies.map(({ name }) => name).join(", ");
    stage.canvas.setAttribute("role", "img");
    stage.canvas.setAttribute("aria-label", `A live simulation in 3D. ${model.title} It contains: ${names}.`);
  });
}
