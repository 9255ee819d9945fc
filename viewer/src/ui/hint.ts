// What a first visitor can do now, in one line: take the hand, close it, lift. It names the means
// that this pointer has, and stays until the thing was lifted or the visitor closes it.

import { POSING_ID } from "../input/posing";
import { takeControl, type Desk } from "./desk";
import { button, h, setText } from "./dom";
import { Lift, thingToLift, type Thing } from "./lift";
import { isTrue, recall, remember } from "./store";

export type PointerKind = "mouse" | "touch";

/** What to do, for a pointer; `leading`: the visitor has the hand already. */
export function hintText(pointer: PointerKind, leading: boolean, thing: string | null): string {
  const down = thing === null ? "" : ` down to the ${thing}`;
  const round = thing === null ? "" : ` round the ${thing}`;
  const lift = thing === null ? "." : ", then drag up.";
  if (!leading) {
    const close = pointer === "touch" ? "A slider then closes it." : "The mouse wheel over the hand closes it.";
    return `Drag the hand${down}. ${close} Drag beside it to look around.`;
  }
  return pointer === "touch"
    ? `Close it${round} with the slider${lift} Two fingers apart bring it nearer; a twist rolls it.`
    : `Close it${round}: wheel over the hand, key G or the slider${lift.replace(", then", ". Then")}`;
}

export function hint(desk: Desk): HTMLElement {
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
    const leading = inputs.active?.id === POSING_ID;
    setText(text, watching ? `Viewer ${holder} leads the hand; you are watching.` : hintText(pointer, leading, thing?.name ?? null));
  };
  // The pointer in use may change: a tablet has a mouse, a laptop a touch screen.
  window.addEventListener("pointerdown", ({ pointerType }) => {
    const kind: PointerKind = pointerType === "touch" ? "touch" : "mouse";
    if (kind === pointer) return;
    pointer = kind;
    refresh();
  });
  feed.on("model", (model) => {
    thing = thingToLift(model);
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
    if (!seen && lift !== null && lift.seen(snapshot)) done();
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
