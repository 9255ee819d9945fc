// The chain from the tracked hand to the object, in the colours of the picture.

import { h, svg } from "./dom";

const LINKS = [
  { name: "tracked hand", fill: "#e8c33a", way: "springs" },
  { name: "bones", fill: "#c9ced6", way: "hold" },
  { name: "flesh", fill: "#dfae96", way: "presses" },
  { name: "object", fill: "#b9813f", way: "" },
] as const;
/** Between two links, in a box of 400 by 74. */
const STEP = 104;

export function helpPicture(): HTMLElement {
  const parts = LINKS.flatMap(({ name, fill, way }, i) => {
    const x = 44 + STEP * i;
    const link = [
      svg("circle", { cx: x, cy: 28, r: 20, fill }),
      svg("text", { x, y: 66, "text-anchor": "middle" }, name),
    ];
    if (way === "") return link;
    const arrow = svg("path", { d: `M${x + 25} 28h48m-7 -5l7 5l-7 5`, class: "way" });
    return [...link, arrow, svg("text", { x: x + STEP / 2, y: 18, "text-anchor": "middle", class: "small" }, way)];
  });
  const words = "The tracked hand pulls the bones by springs, the bones hold the flesh, the flesh presses on the object.";
  return h(
    "figure",
    { class: "help-picture" },
    svg("svg", { viewBox: "0 0 400 74", role: "img", "aria-label": words }, ...parts),
  );
}
