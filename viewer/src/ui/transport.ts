// The bar over the picture: what is shown, whether it is alive, and the clock with its buttons.

import { FLAG } from "../protocol/types";
import { command, type Desk } from "./desk";
import { h, setText } from "./dom";
import { fixed } from "./format";
import { ICONS, icon } from "./icons";
import { playback } from "./playback";
import { iconButton } from "./widgets";

export function transport(desk: Desk): { top: HTMLElement; bottom: HTMLElement } {
  const { connection, feed } = desk.app;
  const title = h("span", { class: "scene-title" });
  const state = h("span", { class: "state" });
  const top = h("header", { class: "top" }, h("h1", {}, "Thenar"), title, state);

  const paused = () => connection.status?.paused ?? false;
  const toggle = () => void command(desk, { type: "run", paused: !paused() });
  const play = iconButton(ICONS.pause, "Pause (P)", toggle);
  const step = iconButton(ICONS.step, "One step (.)", () => void command(desk, { type: "step" }));
  const reset = iconButton(ICONS.reset, "Back to the start (Backspace)", () => {
    command(desk, { type: "reset" });
  });
  const clock = h("span", { class: "clock", title: "Simulated time" });
  const pace = h("span", { class: "pace" });
  const bottom = h(
    "div",
    { class: "transport", role: "toolbar", "aria-label": "Clock" },
    play,
    step,
    reset,
    clock,
    pace,
    playback(desk),
  );

  const add = (key: string, label: string, act: () => void, name?: string) =>
    desk.keys.add({ key, label, group: "Run", act, ...(name === undefined ? {} : { name }) });
  add("p", "Pause or go on", toggle);
  add(" ", "Pause or go on, while you do not pose the hand", toggle, "Space");
  add(".", "One step, while paused", () => void command(desk, { type: "step" }));
  add("backspace", "Back to the start", () => void command(desk, { type: "reset" }), "Backspace");

  const refresh = () => {
    const drawn = feed.snapshot !== null;
    const may = connection.inControl && feed.live && drawn;
    for (const item of [play, step, reset]) item.disabled = !may;
    step.disabled ||= !paused();
    const label = paused() ? "Go on (P)" : "Pause (P)";
    if (play.getAttribute("aria-label") !== label) {
      play.setAttribute("aria-label", label);
      play.title = label;
      play.replaceChildren(icon(paused() ? ICONS.run : ICONS.pause));
    }
    setText(title, feed.model?.title ?? "");
    const open = connection.state === "open";
    const others = (connection.status?.viewers ?? 1) - 1;
    const who = connection.inControl ? "you control" : "watching";
    const crowd = others > 0 ? `, ${others} more ${others === 1 ? "viewer" : "viewers"}` : "";
    const shown = (connection.status?.recording ?? null) === null ? "Live" : "Recorded";
    const live = drawn ? `${shown}: ${who}${crowd}` : "Loading";
    setText(state, !feed.live ? "Replay" : open ? live : "Not connected");
    state.dataset["state"] = !feed.live || (open && !drawn) ? "recorded" : open ? "live" : "lost";
  };
  connection.on("status", refresh);
  connection.on("open", refresh);
  connection.on("close", refresh);
  connection.on("welcome", refresh);
  feed.on("model", refresh);
  feed.on("live", refresh);
  refresh();

  let drawn = false;
  feed.on("model", () => (drawn = false));
  feed.on("snapshot", (snapshot) => {
    if (!drawn) refresh();
    drawn = true;
    setText(clock, `${fixed(snapshot.time, 2)} s`);
    const slow = (snapshot.flags & FLAG.slow) !== 0;
    const still = (snapshot.flags & FLAG.paused) !== 0;
    const failed = (snapshot.flags & FLAG.failed) !== 0;
    const text = failed
      ? "last step failed and was taken back"
      : still
        ? "paused"
        : `${fixed(snapshot.speed, 2)} × real time`;
    setText(pace, text);
    pace.dataset["slow"] = String((slow && !still) || failed);
    pace.title = slow ? "This machine is slower than the chosen speed." : "";
  });
  return { top, bottom };
}
