// The place in a recording that the server shows: a slider in the transport bar, there only then.

import { command, type Desk } from "./desk";
import { h, setText } from "./dom";
import { fixed } from "./format";
import { Throttle } from "./throttle";

/** Between two commands while the slider is dragged, ms. */
const INTERVAL = 150;
/** The slider stays where it was put until the server may have gone there, ms. */
const SETTLE = 600;

export function playback(desk: Desk): HTMLElement {
  const { connection } = desk.app;
  const slider = h("input", {
    type: "range",
    min: 0,
    step: "any",
    "aria-label": "Place in the recording",
  });
  const text = h("span", { class: "place" });
  const element = h("div", { class: "playback", hidden: true }, slider, text);
  let touched = -Infinity;
  const throttle = new Throttle<number>(INTERVAL, (time) => void command(desk, { type: "seek", time }));

  const write = (time: number, end: number) => {
    setText(text, `${fixed(time, 2)} of ${fixed(end, 2)} s`);
    slider.setAttribute("aria-valuetext", `${fixed(time, 2)} s`);
  };
  slider.addEventListener("input", () => {
    touched = performance.now();
    const time = Number(slider.value);
    throttle.push(time);
    write(time, Number(slider.max));
  });

  const refresh = () => {
    const recording = connection.status?.recording ?? null;
    element.hidden = recording === null;
    if (recording === null) return;
    slider.disabled = !connection.inControl || connection.state !== "open";
    element.title = recording.file;
    slider.max = String(recording.end);
    if (throttle.busy || performance.now() - touched < SETTLE) return;
    slider.value = String(recording.time);
    write(recording.time, recording.end);
  };
  for (const name of ["status", "welcome", "open", "close"] as const) connection.on(name, refresh);
  refresh();
  return element;
}
