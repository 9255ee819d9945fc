// What happens before the first picture: reaching the simulation, its model on the way, drawing.

import "./loading.css";
import type { Desk } from "./desk";
import { h, setText } from "./dom";
import { bytes } from "./format";

/** A scene that comes quicker than this needs no word, ms. */
const PATIENCE = 400;

/** The words for a stage of loading; `modelBytes` is the size of the model that has come, or null. */
export function loadingText(connected: boolean, modelBytes: number | null): string {
  if (!connected) return "Reaching the simulation …";
  if (modelBytes === null) return "Loading the model …";
  return `Drawing the model (${bytes(modelBytes)}) …`;
}

export function loading(desk: Desk): HTMLElement {
  const { connection, feed, stage } = desk.app;
  const text = h("span");
  const element = h("div", { class: "loading", role: "status" }, text, h("div", { class: "loading-bar" }, h("i")));
  let timer: ReturnType<typeof setTimeout> | undefined;

  const write = () => {
    const { state, welcome } = connection;
    setText(text, loadingText(state === "open" && welcome !== null, connection.modelBytes?.byteLength ?? null));
    // While the simulation is gone the banner says so.
    if (state === "waiting" || state === "closed") element.hidden = true;
  };
  const wait = () => {
    write();
    clearTimeout(timer);
    timer = setTimeout(() => {
      element.hidden = feed.snapshot !== null;
      write();
    }, PATIENCE);
  };
  stage.onFrame(() => {
    if (stage.snapshot === null) return;
    clearTimeout(timer);
    element.hidden = true;
  });
  feed.on("model", wait);
  for (const name of ["open", "close", "welcome"] as const) {
    connection.on(name, () => (feed.snapshot === null ? wait() : undefined));
  }
  write();
  return element;
}
