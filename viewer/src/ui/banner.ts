// Says plainly when the simulation is gone, and when it is back.

import type { Desk } from "./desk";
import { button, h, setText } from "./dom";

export function banner(desk: Desk): HTMLElement {
  const { connection, feed, stage } = desk.app;
  const text = h("span");
  const again = button("Try now", () => connection.connect());
  const element = h("div", { class: "banner", role: "alert", hidden: true }, text, again);
  let retryAt: number | null = null;
  let ticking: ReturnType<typeof setInterval> | undefined;

  const write = () => {
    const wait = retryAt === null ? null : Math.ceil((retryAt - performance.now()) / 1000);
    const soon = wait === null || wait <= 0 ? "Trying again…" : `Trying again in ${wait} s.`;
    const what =
      connection.welcome === null
        ? "The simulation cannot be reached."
        : "The connection to the simulation is lost; the picture shows its last moment.";
    // Only the first words are worth reading aloud again and again.
    setText(text, `${what} ${soon}`);
  };

  connection.on("close", ({ retryIn, attempts }) => {
    retryAt = retryIn === null ? null : performance.now() + 1000 * retryIn;
    // A single hiccup is over before it could be read.
    if (attempts < 2 && connection.welcome !== null) return;
    element.hidden = false;
    write();
    clearInterval(ticking);
    ticking = setInterval(write, 500);
  });
  connection.on("status", ({ loading, problem = null }) => {
    clearInterval(ticking);
    again.hidden = true;
    const what = loading !== null ? `Loading ${loading}…` : problem;
    element.hidden = what === null;
    if (what !== null) setText(text, what);
  });
  connection.on("open", () => {
    clearInterval(ticking);
    const missed = !element.hidden;
    element.hidden = true;
    if (missed && feed.live) desk.toasts.show("Connected again.");
  });
  connection.on("close", () => (again.hidden = false));
  // The driver was reset, or another page took the memory; three takes up the picture again.
  stage.canvas.addEventListener("webglcontextlost", () => {
    if (connection.state !== "open") return;
    again.hidden = true;
    element.hidden = false;
    setText(text, "The graphics driver dropped the picture. It comes back by itself; if not, reload the page.");
  });
  stage.canvas.addEventListener("webglcontextrestored", () => {
    if (connection.state !== "open") return;
    element.hidden = true;
    stage.invalidate();
  });
  return element;
}
