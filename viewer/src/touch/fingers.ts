// The force on each finger of one hand: a bar for what is sent, a line for what the scene asks for.

import type { Touch } from "../protocol/types";
import { h, setText } from "../ui/dom";
import { fixed, significant } from "../ui/format";

type Hand = Touch["hands"][number];

const FINGERS = ["Thumb", "Index", "Middle", "Ring", "Little"] as const;
/** Of a device that holds one point. */
const AXES = ["x", "y", "z"] as const;

/** Forces of these parts, N, with what they are called. */
export function columns(hand: Hand): { label: string; wanted: number; sent: number }[] {
  const labels = hand.renders === "wrench" ? AXES : FINGERS;
  return labels.map((label, k) => ({ label, wanted: hand.wanted[k] ?? 0, sent: hand.sent[k] ?? 0 }));
}

/** Part of the height that a force takes, 0 to 1. */
export function share(force: number, most: number): number {
  return most > 0 ? Math.min(1, Math.abs(force) / most) : 0;
}

export class Fingers {
  readonly element: HTMLElement;
  private readonly caption = h("span");
  private readonly body = h("div", { class: "touch-bars" });
  private parts: { fill: HTMLElement; wish: HTMLElement; number: HTMLElement }[] = [];
  private labels = "";

  constructor() {
    this.element = h("div", { class: "touch-hand" }, this.caption, this.body);
  }

  show(hand: Hand): void {
    const all = columns(hand);
    const labels = all.map(({ label }) => label).join();
    if (labels !== this.labels) this.build(all.map(({ label }) => label));
    this.labels = labels;
    const side = hand.side === "left" ? "Left hand" : "Right hand";
    const most =
      hand.force_max > 0
        ? `, at most ${significant(hand.force_max, 2)} N${hand.renders === "wrench" ? "" : " a finger"}`
        : ", no force display";
    setText(this.caption, `${side}${hand.tracked ? "" : ", not tracked"}${most}`);
    this.element.dataset["tracked"] = String(hand.tracked);
    all.forEach(({ wanted, sent }, k) => {
      const part = this.parts[k];
      part.fill.style.height = `${fixed(100 * share(sent, hand.force_max), 1)}%`;
      part.wish.style.bottom = `${fixed(100 * share(wanted, hand.force_max), 1)}%`;
      part.wish.hidden = Math.abs(wanted) < 0.005;
      setText(part.number, `${fixed(sent, Math.abs(sent) < 10 ? 2 : 1)} N`);
    });
  }

  private build(labels: readonly string[]): void {
    this.parts = labels.map(() => ({ fill: h("i"), wish: h("b"), number: h("output") }));
    this.body.replaceChildren(
      ...this.parts.map(({ fill, wish, number }, k) =>
        h(
          "div",
          { "data-part": labels[k] },
          h("div", { class: "touch-bar" }, fill, wish),
          number,
          h("small", {}, labels[k]),
        ),
      ),
    );
  }
}
