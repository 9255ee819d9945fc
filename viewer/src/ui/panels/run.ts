// Scene, hands, speed, and who holds control.

import type { HandsChoice } from "../../protocol/types";
import { command, type Desk, type Panel } from "../desk";
import { button, h, setText } from "../dom";
import { bytes, fixed, namePaper, significant } from "../format";
import { ICONS } from "../icons";
import { overlapLines, overlapRemark } from "../overlaps";
import { fillSceneMenu } from "../scene-menu";
import { sceneTiles } from "../scene-tiles";
import { Throttle } from "../throttle";
import { group, segmented, select, slider } from "../widgets";

const HANDS: readonly (readonly [HandsChoice, string])[] = [
  ["scene", "Scene's"],
  ["left", "Left"],
  ["right", "Right"],
  ["both", "Both"],
];

export function runPanel(desk: Desk): Panel {
  const { connection, feed, stage } = desk.app;
  const who = h("p", { class: "who" });
  const take = button("Take control", () => {
    command(desk, { type: "control", take: !connection.inControl });
  });
  const go = (name: string) => void command(desk, { type: "scene", name });
  const scene = select("Scene", [], go);
  const tiles = sceneTiles(go);
  scene.element.classList.add("stacked");
  const about = h("p", { class: "help" });
  const overlaps = h("ul", { class: "help", hidden: true });
  const hands = segmented("Hands", HANDS, (which) => {
    command(desk, { type: "hands", which, lengths: { left: null, right: null } });
  });
  const throttle = new Throttle<number>(100, (value) => void command(desk, { type: "speed", value }));
  const speed = slider(
    "Speed",
    { min: 0.02, max: 1, scale: "log" },
    (value) => (value === 1 ? "real time" : `${significant(value, 2)} × real time`),
    (value) => throttle.push(value),
  );
  const settable = h("fieldset", { class: "bare" }, scene.element, about, overlaps, tiles.element, hands.element, speed.element);
  const line = h("dl", { class: "facts" });
  const body = h("div", {}, group("Control", who, take), settable, group("Connection", line));

  let listed = "";
  const refresh = () => {
    const { status, welcome } = connection;
    const mine = connection.inControl;
    settable.disabled = !mine;
    // What is recorded keeps its scene and its hands.
    const recorded = (status?.recording ?? null) !== null;
    scene.input.disabled = recorded;
    tiles.element.hidden = recorded;
    hands.element.hidden = recorded;
    take.disabled = connection.state !== "open";
    setText(take, mine ? "Give up control" : "Take control");
    const holder = status?.control ?? null;
    setText(
      who,
      connection.state !== "open"
        ? "Not connected."
        : mine
          ? "You hold control. Others can watch."
          : holder === null
            ? "Nobody holds control. You are watching."
            : `Viewer ${holder} holds control. You are watching as viewer ${welcome?.client ?? "?"}.`,
    );
    const scenes = welcome?.scenes ?? [];
    const names = scenes.map(({ name }) => name).join("\n");
    if (names !== listed) {
      fillSceneMenu(scene.input, scenes);
      tiles.fill(scenes);
    }
    listed = names;
    if (status !== null) {
      if (
        !scenes.some((s) => s.name === status.scene) &&
        ![...scene.input.options].some((o) => o.value === status.scene)
      ) {
        scene.input.prepend(h("option", { value: status.scene }, status.scene));
      }
      scene.input.value = status.scene;
      tiles.mark(status.scene);
      hands.set(status.hands);
      if (!throttle.busy) speed.set(status.speed);
    }
  };
  for (const name of ["status", "welcome", "open", "close"] as const) connection.on(name, refresh);
  feed.on("model", (model) => {
    setText(about, namePaper(model.description.replace(/\s+/g, " ").trim()));
    overlaps.replaceChildren(...overlapLines(model.overlaps).map((line) => h("li", {}, line)));
    overlaps.hidden = model.overlaps.length === 0;
    const remark = overlapRemark(model.overlaps);
    if (remark !== null) desk.toasts.show(remark, "warning");
  });
  refresh();

  let timer: ReturnType<typeof setInterval> | undefined;
  const facts = () => {
    const trip = connection.clock.roundTrip;
    const latency = connection.latency.median;
    const fps = fixed(stage.stats.fps, 0);
    const rows: [string, string][] = [
      ["Server", connection.welcome?.server ?? "–"],
      ["Round trip", trip === null ? "–" : `${fixed(1000 * trip, 1)} ms`],
      ["Your pose to picture", latency === null ? "–" : `${fixed(latency, 1)} ms`],
      ["Received", `${bytes(Math.round(connection.throughput.bytesPerSecond))}/s`],
      ["Drawn", `${fps} ${fps === "1" ? "frame" : "frames"}/s, ${fixed(stage.stats.frameCost, 1)} ms of page code each`],
    ];
    line.replaceChildren(...rows.flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]));
  };
  return {
    id: "run",
    title: "Run",
    icon: ICONS.run,
    body,
    shown(open) {
      clearInterval(timer);
      if (open) {
        facts();
        timer = setInterval(facts, 1000);
      }
    },
  };
}
