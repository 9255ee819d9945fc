// Plain-language help: what is seen, what to try, every key.

import type { Desk, Panel } from "./desk";
import { button, h } from "./dom";
import { PAPER } from "./format";
import { helpPicture } from "./help-picture";
import { ICONS } from "./icons";

export function helpPanel(desk: Desk): Panel {
  const keys = h("div", { class: "keys" });
  const dialog = h(
    "dialog",
    { class: "help-dialog", "aria-labelledby": "help-title" },
    h(
      "header",
      {},
      h("h2", { id: "help-title" }, "What this is, and how to use it"),
      button("×", () => dialog.close(), { class: "plain", "aria-label": "Close help" }),
    ),
    ...text(),
    h("h3", {}, "Keys"),
    keys,
  );
  document.body.append(dialog);
  const open = () => {
    keys.replaceChildren(...tables(desk));
    dialog.showModal();
  };
  dialog.addEventListener("click", (event) => {
    if (event.target === dialog) dialog.close();
  });
  desk.keys.add({ key: "?", label: "This help", group: "Page", act: open });
  return {
    id: "help",
    title: "Help",
    icon: ICONS.help,
    body: h(
      "div",
      {},
      helpPicture(),
      h(
        "p",
        {},
        "A soft hand, simulated live: bones follow a pose, flesh follows the bones and gives way to what it touches.",
      ),
      h(
        "ol",
        { class: "steps" },
        ...[
          "Drag the hand down to the object, with the mouse or one finger.",
          "Close it: the mouse wheel over the hand, key G, or the slider that appears. The forces at the fingertips stand below it.",
          "Drag up. Esc gives the hand back to the script.",
        ].map((step) => h("li", {}, step)),
      ),
      h("div", { class: "buttons" }, button("More help, and all keys", open, { class: "primary", title: "Key ?" })),
    ),
  };
}

function text(): HTMLElement[] {
  const list = (...items: string[]) => h("ul", {}, ...items.map((item) => h("li", {}, item)));
  return [
    h(
      "p",
      {},
      "You see a hand of 16 rigid bones inside soft flesh. A script, or you, move a tracked hand; springs pull " +
        "the bones after it. The flesh follows the bones and is stopped by what it touches, so the simulated hand " +
        "stays outside of objects even when the tracked one goes in.",
    ),
    helpPicture(),
    h("h3", {}, "What to try"),
    list(
      "Play the bread scene, pause it (P) when the hand holds the loaf, and go on step by step (.).",
      "Take the hand: drag it with the mouse or a finger, or press M. It moves up, down and sideways; with Shift over the table. Close it with the mouse wheel or the slider. Esc gives it back.",
      "On a touch screen two fingers apart bring the hand nearer, and a twist rolls it.",
      "Open Physics and make the flesh softer or the bread slippery: it acts at once. The arrow beside a value takes it back.",
      "Switch on the tracked hand (Y) and press the hand into the table: yellow goes through, flesh does not.",
      "Switch on the pressure (H): the hand turns to glass and shows where it is pressed. Contact forces (V) are arrows.",
      "Drag beside the hand to turn the camera; wheel or pinch to zoom; keys 1 to 6 for fixed views.",
    ),
    h("h3", {}, "Your own hand"),
    list(
      "A webcam or a headset with hand tracking can move the hand: see the Hand panel.",
      "For a headset, start the program with --lan, open the printed address in the headset's browser, accept its " +
        "certificate once, and enter from the Hand panel.",
    ),
    h("h3", {}, "What the colours mean"),
    list(
      "Yellow: the tracked hand. Skin colour: the simulated one.",
      "Pressure: clear skin bears none; from blue (little) to yellow (most); the scale in kPa is beside the picture.",
      "Joints: blue bend one way, red two ways. Skinning weights: from blue (none) to red (all).",
      "Arrows: light blue presses, pink rubs; the longest arrow's force stands beside the picture.",
      "In the plot: thumb orange-red, index yellow, middle green, ring blue, little pink, palm grey.",
    ),
    h("h3", {}, "The paper"),
    h("p", {}, `Where a scene or a setting speaks of the paper, it is ${PAPER}.`),
    h("h3", {}, "What it does not do"),
    list(
      "Coarse flesh is somewhat stiffer than its material; thenar validate says by how much.",
      "When a machine is too slow for real time, the clock runs slower and says so; nothing is skipped.",
      "It is a research tool, not a medical one.",
    ),
  ];
}

function tables(desk: Desk): HTMLElement[] {
  const groups = new Map<string, HTMLElement>();
  for (const { key, name, label, group } of desk.keys.list) {
    let table = groups.get(group);
    if (table === undefined) {
      table = h("table", {}, h("caption", {}, group));
      groups.set(group, table);
    }
    table.append(h("tr", {}, h("td", {}, h("kbd", {}, name ?? key.toUpperCase())), h("td", {}, label)));
  }
  return [...groups.values()];
}
