// What a first visitor can do now, in one line: take the hand, bring it down, close it, lift. The line
// follows what the hand does, names the means that this pointer has, and stays until the thing was
// lifted or the visitor closes it.

import { POSING_ID, type Posing } from "../input/posing";
import { thingsOf, type Thing } from "../input/things";
import { takeControl, type Desk } from "./desk";
import { button, h, setText } from "./dom";
import { Lift, nextStep, type Step } from "./lift";
import { isTrue, recall, remember } from "./store";

export type PointerKind = "mouse" | "touch";

/** Between two looks at what the hand does, ms. */
const LOOK = 200;

/** What to do next, for a pointer. */
export function hintText(pointer: PointerKind, step: Step, thing: string | null): string {
  const touch = pointer === "touch";
  const what = thing ?? "";
  const down = thing === null ? "" : ` down to the ${what}`;
  const fingers = "Two fingers apart bring it nearer; a twist rolls it.";
  switch (step) {
    case "take":
      return `Drag the hand${down}. ${touch ? "A slider then closes it." : "The mouse wheel over the hand closes it."} Drag beside it to look around.`;
    case "reach":
      return touch
        ? `Drag it${down}, then close it with the slider. ${fingers}`
        : `Drag it${down}, then close it: wheel over the hand, key G or the slider.`;
    case "close": {
      const round = thing === null ? "" : ` round the ${what}`;
      if (touch) return `Close it${round} with the slider${thing === null ? "" : ", then drag up"}. ${fingers}`;
      return `Close it${round}: wheel over the hand, key G or the slider.${thing === null ? "" : " Then drag up."}`;
    }
    case "lift":
      return `You hold the ${what}: drag up to lift it. ${touch ? "The slider opens" : "Wheel and slider open"} the hand.`;
  }
}

export function hint(desk: Desk, posing: Posing): HTMLElement {
  const { connection, feed, inputs, stage } = desk.app;
  const text = h("span");
  const done = () => {
    seen = true;
    remember("hint-seen", true);
    refresh();
  };
  const got = button("Got it", done, { class: "plain" });
  const take = button("Take control", () => takeControl(desk));
  const element = h("div", { class: "hint", role: "status", hidden: true }, text, take, got);
  let seen = recall("hint-seen", isTrue) !== null;
  let pointer: PointerKind = window.matchMedia("(pointer: coarse)").matches ? "touch" : "mouse";
  let thing: Thing | null = null;
  let lift: Lift | null = null;
  let step: Step = "take";
  let looked = -Infinity;

  const next = (): Step => {
    const { model, snapshot } = feed;
    if (inputs.active?.id !== POSING_ID) return "take";
    if (thing === null || model === null || snapshot === null) return "close";
    return nextStep(posing.hand, thing, model, snapshot, step);
  };
  const refresh = () => {
    const { status } = connection;
    const recorded = (status?.recording ?? null) !== null;
    const hands = feed.model?.hands.length ?? 0;
    const other = inputs.active !== null && inputs.active.id !== POSING_ID;
    const none = !feed.live || recorded || hands === 0 || feed.snapshot === null || stage.stats.frames === 0;
    const holder = status?.control ?? null;
    const open = connection.state === "open";
    const watching = open && holder !== null && !connection.inControl;
    element.hidden = seen || none || other || !open;
    take.hidden = !watching;
    step = next();
    setText(text, watching ? `Viewer ${holder} leads the hand; you are watching.` : hintText(pointer, step, thing?.name ?? null));
  };
  // The pointer in use may change: a tablet has a mouse, a laptop a touch screen.
  window.addEventListener("pointerdown", ({ pointerType }) => {
    const kind: PointerKind = pointerType === "touch" ? "touch" : "mouse";
    if (kind === pointer) return;
    pointer = kind;
    refresh();
  });
  feed.on("model", (model) => {
    [thing = null] = thingsOf(model);
    // Whoever leads the hand goes on to lead it in the next scene.
    lift = inputs.active?.id === POSING_ID && thing !== null ? new Lift(thing) : null;
    refresh();
  });
  const drawing = stage.onFrame(() => {
    if (stage.snapshot === null || stage.stats.frames === 0) return;
    drawing();
    refresh();
  });
  feed.on("snapshot", (snapshot) => {
    if (seen) return;
    if (lift !== null && lift.seen(snapshot)) return done();
    const now = performance.now();
    if (now - looked < LOOK) return;
    looked = now;
    if (next() !== step) refresh();
  });
  inputs.onChange(() => {
    const leading = inputs.active?.id === POSING_ID;
    if (!leading) lift = null;
    else if (lift === null && thing !== null) lift = new Lift(thing);
    refresh();
  });
  for (const name of ["open", "close", "status", "welcome"] as const) connection.on(name, refresh);
  feed.on("live", refresh);
  return element;
}
