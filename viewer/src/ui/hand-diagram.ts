// A small open hand, seen on its palm: each finger's pad fills as it is pressed, with its number.

import { PER_DIGIT, type Side } from "../protocol/types";
import { setText, svg } from "./dom";
import { fixed } from "./format";
import { DIGIT_COLOURS, DIGIT_LABELS } from "./quantities";

/** Base, tip and width in a 220 × 190 box, of a left hand's palm side: the thumb is on the left. */
const FINGERS = [
  { from: [78, 150], to: [38, 104], width: 19, label: [24, 88] },
  { from: [84, 102], to: [72, 44], width: 17, label: [62, 26] },
  { from: [106, 98], to: [106, 30], width: 17, label: [106, 12] },
  { from: [127, 102], to: [138, 42], width: 16, label: [149, 24] },
  { from: [146, 114], to: [170, 68], width: 14, label: [187, 54] },
] as const;
const PALM =
  "M76 108 Q74 98 86 98 L142 100 Q154 104 153 118 L148 158 Q144 174 128 176 L94 176 Q80 174 78 160 Z";
const WIDTH = 220;
/** A pad is wholly filled at this normal force, N. */
const FULL = 5;

export class HandDiagram {
  readonly element = svg("svg", { viewBox: "0 0 220 190", class: "hand-diagram", role: "img" });
  private readonly pads: SVGElement[] = [];
  private readonly labels: SVGElement[] = [];
  private readonly title = svg("title");

  constructor() {
    this.build("right");
  }

  build(side: Side): void {
    const flip = (x: number) => (side === "left" ? x : WIDTH - x);
    this.pads.length = 0;
    this.labels.length = 0;
    const skin: SVGElement[] = [];
    const palm = svg("path", { d: PALM, class: "digit" });
    if (side === "right") palm.setAttribute("transform", `translate(${WIDTH} 0) scale(-1 1)`);
    const pad = svg("circle", { cx: flip(114), cy: 142, r: 17, fill: DIGIT_COLOURS[0] });
    const label = svg("text", { x: flip(114), y: 146, class: "force" });
    this.pads.push(pad);
    this.labels.push(label);
    FINGERS.forEach(({ from, to, width, label: at }, f) => {
      skin.push(
        svg("line", {
          x1: flip(from[0]),
          y1: from[1],
          x2: flip(to[0]),
          y2: to[1],
          "stroke-width": width,
          class: "finger",
        }),
      );
      this.pads.push(
        svg("circle", { cx: flip(to[0]), cy: to[1], r: 0.42 * width, fill: DIGIT_COLOURS[f + 1] }),
      );
      this.labels.push(svg("text", { x: flip(at[0]), y: at[1] + 4, class: "force" }));
    });
    this.element.replaceChildren(this.title, ...skin, palm, ...this.pads, ...this.labels);
    this.element.setAttribute("aria-label", `Normal force on each finger of the ${side} hand`);
  }

  /** `fingers`: normal and shear force N, area m², pressure Pa for palm, thumb .. little. */
  show(fingers: ArrayLike<number>): void {
    this.pads.forEach((pad, d) => {
      const force = fingers[PER_DIGIT * d];
      // The square root lets a light touch be seen beside a firm grip.
      const share = Math.min(1, Math.sqrt(Math.max(0, force) / FULL));
      pad.setAttribute("opacity", fixed(force > 0.005 ? 0.25 + 0.75 * share : 0.08, 2));
      const text = force > 0.005 ? `${fixed(force, force < 10 ? 2 : 1)} N` : "";
      setText(this.labels[d], text);
    });
    const touching = DIGIT_LABELS.filter((_, d) => fingers[PER_DIGIT * d] > 0.005);
    setText(this.title, touching.length === 0 ? "Nothing is touched" : `Touching: ${touching.join(", ")}`);
  }
}
