// Everything that can move the hand, one button each.

import type { InputSource } from "../../input/source";
import { sayRefused, type Desk, type Panel } from "../desk";
import { button, h, setText } from "../dom";
import { gripControls } from "../grip-controls";
import { ICONS } from "../icons";

export function inputPanel(desk: Desk): Panel {
  const { inputs, connection, feed } = desk.app;
  const intro = h("p", { class: "help" });
  const list = h("div");
  const rows = new Map<string, () => void>();

  const rowOf = (source: InputSource): HTMLElement => {
    const note = h("p", { class: "note", role: "status" });
    const act = button(
      source.label,
      () => {
        if (inputs.active === source) inputs.stop();
        else {
          inputs.start(source.id).catch((error: unknown) => sayRefused(desk, error));
        }
      },
      { "data-input": source.id, "aria-pressed": "false" },
    );
    const box = h("section", { class: "input-source" }, act, h("p", { class: "help" }, source.help), note);
    if (source.controls !== undefined) box.append(source.controls);
    rows.set(source.id, () => {
      const on = inputs.active === source;
      act.disabled = !source.available || connection.state !== "open" || feed.snapshot === null;
      act.setAttribute("aria-pressed", String(on));
      setText(act, on ? (source.stopLabel ?? `Stop ${source.label.toLowerCase()}`) : source.label);
      setText(note, source.note);
      note.hidden = source.note === "";
      box.dataset["state"] = source.state;
      if (source.controls !== undefined) source.controls.hidden = !source.available;
    });
    return box;
  };

  const refresh = () => {
    for (const source of inputs.list) if (!rows.has(source.id)) list.append(rowOf(source));
    for (const update of rows.values()) update();
    const recorded = (connection.status?.recording ?? null) !== null;
    const live =
      inputs.active === null
        ? "The scene's script moves the hand. Choose what shall move it instead; Esc gives it back."
        : "Esc gives the hand back to the script.";
    setText(intro, recorded ? "This is a recording: its hands move as they did." : live);
  };
  inputs.onChange(refresh);
  let drawn = false;
  feed.on("model", () => {
    drawn = false;
    refresh();
  });
  feed.on("snapshot", () => {
    if (!drawn) refresh();
    drawn = true;
  });
  for (const name of ["open", "close", "status"] as const) connection.on(name, refresh);
  refresh();

  desk.keys.add({
    key: "escape",
    name: "Esc",
    label: "Give the hand back to the script",
    group: "Hand",
    act: () => inputs.stop(),
  });
  return { id: "input", title: "Hand", icon: ICONS.input, body: h("div", {}, intro, gripControls(desk), list) };
}
