// Sliders and shapes for posing, under the button of that input. Touching one takes the hand.

import { POSING_ID, type Posing } from "../input/posing";
import { PRESETS } from "../input/shapes";
import { button, h } from "./dom";
import { sayRefused, type Desk } from "./desk";
import { fixed } from "./format";
import { select, slider } from "./widgets";

const SHARE = { min: 0, max: 1, scale: "linear" } as const;
const DIGITS = ["Thumb", "Index finger", "Middle finger", "Ring finger", "Little finger"] as const;
/** The sliders follow the script's hand this often, ms. */
const FOLLOW = 200;

export function posingControls(desk: Desk, posing: Posing): HTMLElement {
  const { inputs, feed } = desk.app;
  /** Acts once the hand is ours. */
  const withHand = (act: () => void) => {
    if (posing.on) return act();
    inputs.start(POSING_ID).then(
      () => act(),
      (error: unknown) => sayRefused(desk, error),
    );
  };
  const percent = (value: number) => `${fixed(100 * value, 0)} %`;
  const grasp = slider("Grasp", SHARE, percent, (value) => withHand(() => posing.setGrasp(value)));
  const fingers = DIGITS.map((label, digit) =>
    slider(label, SHARE, percent, (value) => withHand(() => posing.setCurl(digit, value))),
  );
  const spread = slider("Spread", { min: -1, max: 1, scale: "linear" }, percent, (value) =>
    withHand(() => posing.setSpread(value)),
  );
  const shapes = PRESETS.map((name) =>
    button(name[0].toUpperCase() + name.slice(1).replace("-", " "), () => withHand(() => posing.shape(name))),
  );
  const which = select("Hand", [], (value) => posing.choose(Number(value)));
  which.element.hidden = true;
  const element = h(
    "div",
    { class: "posing" },
    which.element,
    grasp.element,
    h("div", { class: "buttons", role: "group", "aria-label": "Hand shapes" }, ...shapes),
    h("details", {}, h("summary", {}, "Finger by finger"), ...fingers.map((f) => f.element), spread.element),
  );

  const refresh = () => {
    if (element.offsetParent === null) return;
    const now = posing.sliders();
    grasp.set(now.grasp);
    fingers.forEach((item, digit) => item.set(now.curls[digit]));
    spread.set(now.spread);
    which.input.value = String(posing.hand);
  };
  feed.on("model", (model) => {
    which.element.hidden = model.hands.length < 2;
    which.input.replaceChildren(
      ...model.hands.map((hand, i) => h("option", { value: i }, `${hand.name} (${hand.side ?? "no side"})`)),
    );
  });
  let last = 0;
  feed.on("snapshot", () => {
    const now = performance.now();
    if (now - last < FOLLOW) return;
    last = now;
    refresh();
  });
  return element;
}
