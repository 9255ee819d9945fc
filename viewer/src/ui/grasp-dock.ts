// The grasp and what it does, side by side over the picture: one slider that closes the hand, and
// the normal force at each fingertip of every hand that the visitor leads. It shows while one is led.

import "./dock.css";
import { POSING_ID, type Posing } from "../input/posing";
import { PER_DIGIT, PER_HAND } from "../protocol/types";
import type { Desk } from "./desk";
import { h, setText } from "./dom";
import { fixed } from "./format";
import { handName, ledHands } from "./led-hands";
import { DIGIT_COLOURS, DIGIT_LABELS, HANDS_MOST } from "./quantities";
import { slider } from "./widgets";

/** Between two updates of the numbers: faster ones cannot be read, ms. */
const REFRESH = 100;
/** A bar is full at this normal force, N; a firm grip of the loaf presses with 10 N. */
const FULL = 10;
/** Below this force a fingertip counts as free: numbers round to 0.00 there, N. */
const FREE = 0.005;

/** Normal force at the thumb, index, middle, ring and little finger of one hand, N. */
export function fingertipForces(fingers: Float32Array, hand: number): number[] {
  return [1, 2, 3, 4, 5].map((digit) => fingers[PER_HAND * hand + PER_DIGIT * digit] ?? 0);
}

/** A force in newtons, in three digits at most. */
export function forceText(force: number): string {
  return `${fixed(force, force < 9.995 ? 2 : 1)} N`;
}

interface Row {
  readonly element: HTMLElement;
  /** Names the hand where the scene has several. */
  name(text: string, shown: boolean): void;
  write(forces: readonly number[]): void;
}

/** The forces at one hand's fingertips, side by side. */
function forceRow(): Row {
  const title = h("small", { class: "dock-hand" });
  const cells = DIGIT_LABELS.slice(1).map((label, f) => {
    const force = h("output");
    const fill = h("i");
    fill.style.background = DIGIT_COLOURS[f + 1];
    const name = h("small", {}, label);
    return { force, fill, element: h("div", { "data-digit": label }, name, force, h("div", { class: "dock-bar" }, fill)) };
  });
  const forces = h("div", { class: "dock-forces", role: "group" }, ...cells.map(({ element }) => element));
  return {
    element: h("div", {}, title, forces),
    name(text, shown) {
      setText(title, text);
      title.hidden = !shown;
      forces.setAttribute("aria-label", `Normal force at each fingertip${shown ? `, ${text}` : ""}`);
    },
    write(values) {
      values.forEach((force, f) => {
        const { force: text, fill, element: cell } = cells[f];
        setText(text, forceText(force));
        // The square root shows a light touch beside a firm grip.
        fill.style.width = `${fixed(100 * Math.min(1, Math.sqrt(Math.max(0, force) / FULL)), 0)}%`;
        cell.dataset["free"] = String(force < FREE);
      });
    },
  };
}

export function graspDock(desk: Desk, posing: Posing): HTMLElement {
  const { inputs, feed } = desk.app;
  const close = slider(
    "Close the hand",
    { min: 0, max: 1, scale: "linear" },
    (value) => `${fixed(100 * value, 0)} %`,
    (value) => posing.setGrasp(value),
  );
  const rows = Array.from({ length: HANDS_MOST }, forceRow);
  const list = h("div", { class: "dock-rows" });
  const element = h("section", { class: "dock", "aria-label": "Your grasp", hidden: true }, close.element, list);
  let shown: number[] = [];

  const refresh = () => {
    const { snapshot, model } = feed;
    if (element.hidden || snapshot === null || model === null) return;
    close.set(posing.sliders().grasp);
    shown = ledHands(model.hands, inputs.active?.led() ?? [], shown);
    const used = rows.slice(0, shown.length);
    if (list.childElementCount !== used.length) list.replaceChildren(...used.map((row) => row.element));
    used.forEach((row, r) => {
      row.name(handName(model.hands[shown[r]]), model.hands.length > 1);
      row.write(fingertipForces(snapshot.fingers, shown[r]));
    });
  };
  const show = () => {
    element.hidden = inputs.active === null || !feed.live || (feed.model?.hands.length ?? 0) === 0;
    // A tracked hand closes by itself: there is nothing to slide.
    close.element.hidden = inputs.active?.id !== POSING_ID;
    refresh();
  };
  inputs.onChange(show);
  feed.on("model", () => {
    shown = [];
    show();
  });
  feed.on("live", show);
  let last = -Infinity;
  feed.on("snapshot", () => {
    const now = performance.now();
    if (now - last < REFRESH) return;
    last = now;
    refresh();
  });
  return element;
}
