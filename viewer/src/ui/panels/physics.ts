// The settings the server offers, grouped, acting at once.

import { isChoice, type RangeSetting, type Setting } from "../../protocol/types";
import { command, takeControl, type Desk, type Panel } from "../desk";
import { button, h, newId, setText } from "../dom";
import { plainPowers, quantity, significant, typedNumber, unitWords } from "../format";
import { ICONS } from "../icons";
import { SLIDER_STEPS, clampTo, fromPosition, sameValue, toPosition } from "../slider-map";
import { Throttle } from "../throttle";

/** Between two commands of one slider, ms. */
const INTERVAL = 100;
/** A value just set here is not overwritten by older ones from the server for so long, ms. */
const SETTLE = 400;

const WATCHING = "You are watching. Take control to change these.";
const RECORDED = "This is a recording: the settings are those of then.";

/** The label of a row with a button that shows its help. */
function labelled(id: string, helpId: string) {
  const label = h("label", { for: id });
  const help = h("p", { class: "help", id: helpId, hidden: true });
  const more = button(
    "?",
    () => {
      help.hidden = !help.hidden;
      more.setAttribute("aria-expanded", String(!help.hidden));
    },
    { class: "plain more", "aria-expanded": "false", "aria-controls": helpId },
  );
  const name = (setting: Setting) => {
    setText(label, setting.label);
    const text = plainPowers(setting.help);
    setText(help, text);
    more.title = text;
    more.setAttribute("aria-label", `What ${setting.label} does`);
  };
  return { head: h("span", { class: "head" }, label, more), help, name };
}

interface Row {
  readonly element: HTMLElement;
  /** Takes over the server's value. */
  update(setting: Setting): void;
}

export function physicsPanel(desk: Desk): Panel {
  const { connection } = desk.app;
  const rows = new Map<string, Row>();
  let shape = "";

  const send = (key: string, value: number | string) => void command(desk, { type: "set", key, value });
  const watching = h(
    "p",
    { class: "help" },
    WATCHING,
  );
  const list = h("div");
  const reset = button("Back to the scene's values", () => {
    for (const { key, value, own } of connection.status?.settings ?? []) if (!sameValue(value, own)) send(key, own);
  });
  const take = button("Take control", () => takeControl(desk));
  const form = h("fieldset", { class: "bare" }, list, reset);

  const rebuild = (settings: readonly Setting[]) => {
    rows.clear();
    const groups = new Map<string, HTMLElement>();
    for (const setting of settings) {
      const row = isChoice(setting) ? choiceRow(setting.key, send) : rangeRow(setting.key, send);
      rows.set(setting.key, row);
      let box = groups.get(setting.group);
      if (box === undefined) {
        const id = newId("settings");
        box = h("div", { class: "group", role: "group", "aria-labelledby": id }, h("h3", { id }, setting.group));
        groups.set(setting.group, box);
      }
      box.append(row.element);
    }
    list.replaceChildren(...groups.values());
  };

  const refresh = () => {
    const { status } = connection;
    const recorded = (status?.recording ?? null) !== null;
    form.disabled = recorded || !connection.inControl;
    watching.hidden = !form.disabled;
    take.hidden = recorded || !form.disabled || connection.state !== "open";
    setText(watching, recorded ? RECORDED : WATCHING);
    if (status === null) return;
    const now = JSON.stringify(status.settings.map((s) => [s.key, s.group, isChoice(s) ? s.choices : 0]));
    if (now !== shape) rebuild(status.settings);
    shape = now;
    for (const setting of status.settings) rows.get(setting.key)?.update(setting);
  };
  for (const name of ["status", "welcome", "close"] as const) connection.on(name, refresh);
  refresh();
  return { id: "physics", title: "Physics", icon: ICONS.physics, body: h("div", {}, watching, take, form) };
}

function rangeRow(key: string, send: (key: string, value: number) => void): Row {
  const [id, helpId] = [newId("set"), newId("help")];
  const { head, help, name } = labelled(id, helpId);
  const range = h("input", {
    id,
    type: "range",
    min: 0,
    max: SLIDER_STEPS,
    step: 1,
    "data-setting": key,
    "aria-describedby": helpId,
  });
  // Of text: a field of numbers would take no power of ten but one with an e.
  const field = h("input", { type: "text", class: "value" });
  const unit = h("span", { class: "unit" });
  const back = button(
    "↺",
    () => {
      if (setting !== null) change(setting.own, true);
    },
    { class: "plain" },
  );
  let setting: RangeSetting | null = null;
  let touched = -Infinity;
  const throttle = new Throttle<number>(INTERVAL, (value) => send(key, value));

  const show = (value: number) => {
    if (setting === null) return;
    range.value = String(Math.round(toPosition(value, setting)));
    range.setAttribute("aria-valuetext", quantity(value, setting.unit));
    if (document.activeElement !== field) field.value = significant(value, 4);
    back.hidden = sameValue(setting.own, value);
  };
  const change = (value: number, all: boolean) => {
    touched = performance.now();
    throttle.push(value);
    if (all) show(value);
    else field.value = significant(value, 4);
  };
  range.addEventListener("input", () => {
    if (setting !== null) change(fromPosition(Number(range.value), setting), false);
  });
  field.addEventListener("change", () => {
    if (setting === null) return;
    const value = typedNumber(field.value);
    if (Number.isFinite(value)) change(clampTo(value, setting), true);
    else show(setting.value);
  });
  return {
    element: h("div", { class: "setting" }, head, back, field, unit, range, help),
    update(next) {
      if (isChoice(next)) return;
      setting = next;
      name(next);
      // Pure numbers have the unit 1.
      const unitText = next.unit === "1" ? "" : unitWords(next.unit);
      setText(unit, unitText);
      unit.title = plainPowers(next.help);
      field.setAttribute("aria-label", unitText === "" ? next.label : `${next.label}, ${unitText}`);
      back.setAttribute("aria-label", `${next.label}: back to the scene's value`);
      back.title = "Back to the scene's value";
      back.hidden = sameValue(next.own, next.value);
      if (!throttle.busy && performance.now() - touched > SETTLE) show(next.value);
    },
  };
}

function choiceRow(key: string, send: (key: string, value: string) => void): Row {
  const [id, helpId] = [newId("set"), newId("help")];
  const { head, help, name } = labelled(id, helpId);
  const input = h("select", { id, "data-setting": key, "aria-describedby": helpId });
  input.addEventListener("change", () => send(key, input.value));
  return {
    element: h("div", { class: "setting choice" }, head, input, help),
    update(next) {
      if (!isChoice(next)) return;
      name(next);
      if (input.options.length !== next.choices.length) {
        input.replaceChildren(...next.choices.map((choice) => h("option", { value: choice }, choice)));
      }
      input.value = next.value;
    },
  };
}
