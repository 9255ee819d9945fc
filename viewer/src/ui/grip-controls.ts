// What the hand grips, and how: one button grips what is under it, another lets go.

import type { GripKind } from "../protocol/types";
import { command, type Desk } from "./desk";
import { button, h } from "./dom";
import { group, select } from "./widgets";

const KINDS: readonly (readonly [GripKind, string])[] = [
  ["pinch", "Pinch: thumb and index finger"],
  ["tripod", "Tripod: thumb, index and middle finger"],
  ["power", "Power: thumb against the four fingers"],
  ["hook", "Hook: the four fingers"],
  ["lateral", "Lateral: thumb and side of the index finger"],
];

export function gripControls(desk: Desk): HTMLElement {
  const { connection, feed } = desk.app;
  const kind = select("Kind of grip", KINDS, () => undefined);
  const grip = () => void command(desk, { type: "grip", kind: kind.input.value as GripKind });
  const release = () => void command(desk, { type: "release" });
  const buttons = [button("Grip what is under the hand (J)", grip), button("Let go (Shift J)", release)];

  const refresh = () => {
    const recorded = (connection.status?.recording ?? null) !== null;
    const hands = feed.model?.hands.length ?? 0;
    for (const item of buttons) item.disabled = !connection.inControl || !feed.live || recorded || hands === 0;
  };
  for (const name of ["open", "close", "status", "welcome"] as const) connection.on(name, refresh);
  feed.on("model", refresh);
  feed.on("live", refresh);
  refresh();

  desk.keys.add({ key: "j", label: "Grip what is under the hand", group: "Hand", act: grip });
  desk.keys.add({ key: "shift+j", name: "Shift J", label: "Let go", group: "Hand", act: release });
  return group(
    "Grip",
    h("p", { class: "help" }, "The fingers close by themselves on what is under the hand, whatever moves the wrist."),
    kind.element,
    h("div", { class: "buttons" }, ...buttons),
  );
}
