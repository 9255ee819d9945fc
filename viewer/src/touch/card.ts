// The devices on the page: whether forces are on, why not, which devices are there, the force on
// each finger, how regular the loop is, and the buttons to arm and to stop.

import "./card.css";
import type { Touch } from "../protocol/types";
import { command, type Desk } from "../ui/desk";
import { button, h, setText } from "../ui/dom";
import { fixed } from "../ui/format";
import { ArmDialog } from "./arm-dialog";
import { Devices } from "./devices";
import { Fingers } from "./fingers";

/** The page looks so often whether reports still come, ms. */
const LOOK = 500;

/** What a device does, in words. */
export function deviceText({ connected, silent_s, tracks, shows }: Touch["devices"][number]): string {
  const does = [tracks ? "tracks" : "", shows ? "shows force" : ""].filter((word) => word !== "").join(", ");
  const silent =
    silent_s === null ? "silent so far" : silent_s > 1 ? `silent for ${fixed(silent_s, 0)} s` : "connected";
  return `${connected ? silent : "not connected"} · ${does}`;
}

/** How regular the loop is, in words, and whether that is good enough. */
export function loopText(touch: Touch, devices: Devices): { text: string; late: boolean } {
  const period = `${fixed(touch.period_p999_us / 1000, 2)} ms`;
  const deadlines = devices.deadlines();
  const missed =
    deadlines === null
      ? `${touch.missed} deadlines missed`
      : `${deadlines.missed} of the last ${deadlines.of} deadlines missed`;
  const late = deadlines !== null && deadlines.missed > 0.001 * deadlines.of;
  return { text: `${fixed(touch.rate, 0)} Hz, 99.9 % of periods within ${period}, ${missed}`, late };
}

/** Shown while the server has devices. */
export function touchCard(desk: Desk): HTMLElement {
  const { connection } = desk.app;
  const devices = new Devices({
    send: (what) => connection.send(what),
    me: () => connection.welcome?.client ?? null,
  });
  const dialog = new ArmDialog((keep) => {
    // Who may not is told so.
    if (!connection.inControl) command(desk, { type: "arm" });
    else devices.arm(keep, performance.now());
    draw();
  });
  document.body.append(dialog.element);

  const headline = h("strong");
  const reason = h("p", { class: "touch-reason" });
  const keeper = h("p", { class: "touch-keeper" });
  const stopNow = () => {
    devices.stop(performance.now());
    draw();
  };
  const arm = button("Arm…", () => dialog.ask(devices.touch?.statement ?? ""), { class: "arm" });
  const stop = button("Stop", stopNow, {
    class: "stop",
    title: "No force at once (key Esc)",
    "aria-keyshortcuts": "Escape",
  });
  stop.append(h("kbd", {}, "Esc"));
  const list = h("ul", { class: "touch-devices" });
  const hands = h("div", { class: "touch-hands" });
  const fingers: Fingers[] = [];
  const loop = h("p", { class: "touch-loop" });
  const told = h("ul");
  const summary = h("summary");
  const more = h("details", {}, summary, told);
  const element = h(
    "section",
    { class: "touch", "aria-label": "Devices", hidden: true },
    h(
      "header",
      {},
      h("div", { role: "status" }, headline, reason),
      h("div", { class: "buttons" }, arm, stop),
    ),
    keeper,
    list,
    hands,
    loop,
    more,
  );

  const draw = () => {
    const { touch } = devices;
    if (touch === null) return;
    const now = performance.now();
    const level = devices.level(now);
    element.hidden = false;
    element.dataset["level"] = level;
    element.dataset["state"] = touch.state;
    setText(headline, devices.headline(now));
    setText(reason, devices.reason(now));
    setText(keeper, devices.keeper(now));
    arm.hidden = level === "armed" || level === "unknown";
    arm.disabled = touch.state === "failed" || !connection.inControl || devices.isArming(now);
    arm.title = connection.inControl ? "" : "Another viewer holds control; take it in the Run panel.";
    document.title = level === "armed" ? "ARMED – Thenar" : "Thenar";
    drawDevices(list, touch);
    while (fingers.length < touch.hands.length) {
      const next = new Fingers();
      fingers.push(next);
      hands.append(next.element);
    }
    fingers.forEach((one, k) => {
      const hand = touch.hands[k];
      one.element.hidden = hand === undefined || level === "unknown";
      if (hand !== undefined) one.show(hand);
    });
    const { text, late } = loopText(touch, devices);
    setText(loop, text);
    loop.dataset["late"] = String(late);
    drawMessages(touch);
  };
  const drawMessages = ({ warnings, messages }: Touch) => {
    const lines = [...warnings.map((line) => `Warning: ${line}`), ...messages.toReversed()];
    more.hidden = lines.length === 0;
    const count =
      warnings.length === 0 ? "" : `, ${warnings.length} ${warnings.length === 1 ? "warning" : "warnings"}`;
    setText(summary, `Messages${count}`);
    if (told.dataset["lines"] === lines.join("\n")) return;
    told.dataset["lines"] = lines.join("\n");
    told.replaceChildren(...lines.map((line) => h("li", {}, line)));
  };

  connection.on("open", () => devices.opened(performance.now()));
  connection.on("close", () => {
    devices.closed();
    // What they are sent is not known any more.
    desk.app.stage.setDevices([]);
    draw();
  });
  connection.on("touch", (touch) => {
    devices.reported(touch, performance.now());
    desk.app.stage.setDevices(touch.hands);
    draw();
  });
  connection.on("status", draw);
  setInterval(draw, LOOK);

  // Seen before anything else, whatever has the focus and whatever dialog is open.
  const escape = (event: KeyboardEvent) => {
    if (event.key === "Escape" && devices.touch !== null) stopNow();
  };
  window.addEventListener("keydown", escape, { capture: true });
  desk.keys.add({
    key: "escape",
    name: "Esc",
    label: "Stop all forces of devices, at any time",
    group: "Devices",
    act: stopNow,
    // What is above has done it.
    when: () => false,
  });
  return element;
}

function drawDevices(list: HTMLElement, touch: Touch): void {
  const lines = touch.devices.map(
    (device) => [device.name, deviceText(device), String(device.connected)] as const,
  );
  const key = JSON.stringify(lines);
  if (list.dataset["lines"] === key) return;
  list.dataset["lines"] = key;
  list.replaceChildren(
    ...lines.map(([name, text, connected]) =>
      h("li", { "data-connected": connected }, h("b", { title: name }, name), h("span", {}, text)),
    ),
  );
}
