// What the picture shows, each layer with what it means.

import { LAYERS, LAYER_LABELS, VIEWS, type LayerName, type ViewName } from "../../scene/layers";
import type { Desk, Panel } from "../desk";
import { button, h, newId } from "../dom";
import { fixed } from "../format";
import { ICONS } from "../icons";
import { group, select, slider } from "../widgets";
import { weightBones } from "./weight-bones";

interface Explanation {
  readonly key: string;
  readonly text: string;
}

const EXPLAIN: Readonly<Record<LayerName, Explanation>> = {
  skin: { key: "k", text: "The soft surface you would see, carried by the flesh." },
  flesh: { key: "t", text: "The tetrahedra that are computed, inside the skin." },
  bones: { key: "b", text: "The rigid bones and the joints between them: hinges blue, universal joints red." },
  tracked: {
    key: "y",
    text: "In yellow: where the tracker puts the hand. Contact holds the real one back.",
  },
  skinning: { key: "l", text: "The same pose by plain skinning, without flesh." },
  contacts: { key: "c", text: "Points where bodies touch: green sticks, orange slides." },
  forces: {
    key: "v",
    text: "Arrows at the contacts, as long as the force is strong: pressing and friction.",
  },
  pressure: { key: "h", text: "Force per area as colour, seen through the hand: clear skin bears nothing, blue little, yellow most." },
  weights: {
    key: "n",
    text: "How much the bones chosen below carry the skin: blue not at all, red alone.",
  },
  wireframe: { key: "w", text: "The edges of the objects' triangles." },
  objects: { key: "o", text: "What the hand touches." },
  shadows: { key: "x", text: "Soft shadows; off is quicker to draw." },
  ground: { key: "z", text: "The table or floor." },
};

const VIEW_LABELS: Readonly<Record<ViewName, string>> = {
  scene: "Scene's own",
  front: "Front",
  side: "Side",
  top: "Top",
  below: "Below",
  close: "Close",
};

export function layersPanel(desk: Desk): Panel & { refresh(): void } {
  const { stage } = desk.app;
  const boxes = new Map<LayerName, HTMLInputElement>();
  const set = (layer: LayerName, on: boolean) => {
    stage.setLayer(layer, on);
    refresh();
  };
  const bones = weightBones(desk);
  const refresh = () => {
    for (const [layer, box] of boxes) box.checked = stage.layer(layer);
    bones.show(stage.layer("weights"));
  };
  const rows = LAYERS.flatMap((layer) => {
    const { key, text } = EXPLAIN[layer];
    const help = newId("layer");
    const box = h("input", {
      type: "checkbox",
      "data-layer": layer,
      "aria-label": LAYER_LABELS[layer],
      "aria-describedby": help,
      "aria-keyshortcuts": key,
    });
    box.checked = stage.layer(layer);
    box.addEventListener("change", () => set(layer, box.checked));
    boxes.set(layer, box);
    desk.keys.add({
      key,
      label: LAYER_LABELS[layer],
      group: "Layers",
      act: () => set(layer, !stage.layer(layer)),
    });
    const row = h(
      "label",
      { class: "layer" },
      box,
      h("span", { class: "name" }, LAYER_LABELS[layer]),
      h("kbd", {}, key.toUpperCase()),
      h("span", { class: "help", id: help }, text),
    );
    return layer === "weights" ? [row, bones.element] : [row];
  });
  const views = VIEWS.map((view, i) => {
    const key = String(i + 1);
    desk.keys.add({
      key,
      label: `View: ${VIEW_LABELS[view].toLowerCase()}`,
      group: "Camera",
      act: () => stage.setView(view),
    });
    return button(VIEW_LABELS[view], () => stage.setView(view), { title: `Key ${key}` });
  });
  let axis: "x" | "y" | "z" | null = null;
  let part = 0.5;
  const cut = () => {
    stage.setClip(axis, part);
    where.element.hidden = axis === null;
  };
  const along = select(
    "Cut the flesh",
    [
      ["", "not"],
      ["x", "along x"],
      ["y", "along y"],
      ["z", "along z"],
    ],
    (value) => {
      axis = value === "x" || value === "y" || value === "z" ? value : null;
      cut();
    },
  );
  const where = slider(
    "Shown part",
    { min: 0, max: 1, scale: "linear" },
    (v) => `${fixed(100 * v, 0)} %`,
    (v) => {
      part = v;
      cut();
    },
  );
  where.set(part);
  where.element.hidden = true;
  return {
    id: "layers",
    title: "Layers",
    icon: ICONS.layers,
    body: h(
      "div",
      {},
      h("div", { class: "layers" }, ...rows),
      group(
        "Section",
        h("p", { class: "help" }, "Looks inside the flesh layer."),
        along.element,
        where.element,
      ),
      group("View", h("div", { class: "buttons" }, ...views)),
    ),
    refresh,
  };
}
