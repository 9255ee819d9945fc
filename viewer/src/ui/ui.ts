// Puts the panels, bars and shortcuts around the picture.

import type { App } from "../app";
import { PointerPosing } from "../input/pointer";
import { Posing } from "../input/posing";
import { PosingKeys } from "../input/posing-keys";
import { touchCard } from "../touch/card";
import { banner } from "./banner";
import type { Desk } from "./desk";
import { button, h } from "./dom";
import { helpPanel } from "./help";
import { Keys } from "./keys";
import { openLink } from "./open-link";
import { forcesPanel } from "./panels/forces";
import { inputPanel } from "./panels/input";
import { layersPanel } from "./panels/layers";
import { physicsPanel } from "./panels/physics";
import { picturePanel } from "./panels/picture";
import { recordPanel } from "./panels/record";
import { runPanel } from "./panels/run";
import { posingControls } from "./posing-controls";
import { Shell } from "./shell";
import { isTrue, recall, remember } from "./store";
import { Toasts } from "./toasts";
import { transport } from "./transport";
import { parseLink } from "./view-link";

export function mountUi(app: App, root: HTMLElement): Desk {
  const desk: Desk = { app, keys: new Keys(), toasts: new Toasts() };
  const say = (message: string) => desk.toasts.show(message, "warning");
  const posing = new Posing(app);
  posing.controls = posingControls(desk, posing);
  app.inputs.register(posing);
  new PointerPosing(app, posing, say);
  new PosingKeys(app, posing, desk.keys, say);

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
  const corner = h("div", { class: "corner" }, desk.toasts.element, hint(app), touchCard(desk), bottom);
  root.append(top, corner, shell.drawer, shell.rail, banner(desk));

  let bare = false;
  desk.keys.add({
    key: "u",
    label: "Hide or show everything but the picture",
    group: "Page",
    act: () => shell.hideAll((bare = !bare)),
  });
  app.connection.on("error", ({ message }) => desk.toasts.show(message, "error"));
  describe(app);

  const link = parseLink(window.location.hash);
  openLink(app, link, say);
  layers.refresh();
  shell.restore(["forces"]);
  bare = !link.ui;
  shell.hideAll(bare);
  // The address is changed by hand or a link is followed: begin anew with it.
  window.addEventListener("hashchange", () => window.location.reload());
  return desk;
}

/** One line for first visitors, gone once they have done something. */
function hint(app: App): HTMLElement {
  const element = h("p", { class: "hint" });
  if (recall("hint-seen", isTrue) !== null) {
    element.hidden = true;
    return element;
  }
  let seen = false;
  const gone = () => {
    seen = element.hidden = true;
    remember("hint-seen", true);
  };
  element.append(
    "Drag the hand to take it. Drag beside it to look around. Help tells the rest (key ?).",
    button("Got it", gone, { class: "plain" }),
  );
  // Scenes without a hand have nothing to take, and recorded hands cannot be.
  app.feed.on("model", ({ hands }) => {
    const recorded = (app.connection.status?.recording ?? null) !== null;
    element.hidden = seen || recorded || hands.length === 0;
  });
  app.inputs.onChange(() => {
    if (app.inputs.active !== null) gone();
  });
  return element;
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
