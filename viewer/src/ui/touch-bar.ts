// Devices that feel the scene: what they do, and the buttons to arm and to stop them.

import type { Touch } from "../protocol/types";
import { command, type Desk } from "./desk";
import { button, h, setText } from "./dom";
import { fixed } from "./format";

const STATES: Readonly<Record<Touch["state"], string>> = {
  "dry-run": "Dry run: no force goes out",
  waiting: "Armed, no force",
  ramping: "Armed, force grows",
  live: "Armed, full force",
  tripped: "Stopped",
  failed: "The haptic loop has failed; start the program again",
};

/** One line on the state of the devices. */
export function touchText(touch: Touch): string {
  const reason = touch.reason === null ? "" : `: ${touch.reason}`;
  const forces = touch.hands.flatMap((hand) => hand.sent);
  const most = fixed(Math.max(0, ...forces), 1);
  const period = fixed(touch.period_p999_us / 1000, 2);
  return `${STATES[touch.state]}${reason} · ${most} N · ${touch.rate} Hz, period p99.9 ${period} ms, ${touch.missed} missed`;
}

/** Shown while the server has devices. */
export function touchBar(desk: Desk): HTMLElement {
  const { connection } = desk.app;
  let statement = "";
  const text = h("span", { role: "status" });
  const arm = button("Arm", () => {
    if (window.confirm(`${statement}\n\nLet forces through?`)) command(desk, { type: "arm" });
  });
  // Anybody may stop, in control or not.
  const stop = button("Stop", () => void connection.send({ type: "stop" }), { class: "stop" });
  const element = h("div", { class: "touch-bar", hidden: true }, text, arm, stop);
  connection.on("touch", (touch) => {
    element.hidden = false;
    statement = touch.statement;
    element.dataset.state = touch.state;
    element.title = [...touch.warnings, touch.message ?? ""].filter((line) => line !== "").join("\n");
    setText(text, touchText(touch));
    const armed = ["waiting", "ramping", "live"].includes(touch.state);
    arm.disabled = armed || touch.state === "failed";
  });
  // What is not heard of is not known: only stopping makes sense.
  connection.on("close", () => {
    setText(text, "The state of the devices is not known");
    arm.disabled = true;
  });
  return element;
}
