// Form parts that several panels use.

import { h, newId, type Child } from "./dom";
import { icon } from "./icons";
import { SLIDER_STEPS, fromPosition, toPosition, type Range } from "./slider-map";

export function iconButton(path: string, label: string, act: () => void): HTMLButtonElement {
  const element = h("button", { type: "button", class: "icon-button", "aria-label": label, title: label });
  element.append(icon(path));
  element.addEventListener("click", act);
  return element;
}

/** A heading with what belongs under it. */
export function group(title: string, ...children: Child[]): HTMLElement {
  const id = newId("group");
  return h("div", { class: "group", role: "group", "aria-labelledby": id }, h("h3", { id }, title), ...children);
}

export interface Slider {
  readonly element: HTMLElement;
  readonly input: HTMLInputElement;
  /** Shows a value; the slider under the visitor's finger is left alone. */
  set(value: number): void;
}

/** A labelled slider with its value in words. */
export function slider(
  label: string,
  range: Range,
  say: (value: number) => string,
  moved: (value: number) => void,
): Slider {
  const id = newId("slider");
  const input = h("input", { id, type: "range", min: 0, max: SLIDER_STEPS, step: 1 });
  const output = h("output", { for: id });
  const write = (value: number) => {
    output.textContent = say(value);
    input.setAttribute("aria-valuetext", say(value));
  };
  let held = false;
  input.addEventListener("input", () => {
    const value = fromPosition(Number(input.value), range);
    write(value);
    moved(value);
  });
  input.addEventListener("pointerdown", () => (held = true));
  for (const end of ["pointerup", "pointercancel", "change", "blur"]) {
    input.addEventListener(end, () => (held = false));
  }
  return {
    element: h("div", { class: "slider" }, h("label", { for: id }, label), output, input),
    input,
    set(value) {
      if (held) return;
      input.value = String(Math.round(toPosition(value, range)));
      write(value);
    },
  };
}

export interface Choice<T extends string> {
  readonly element: HTMLElement;
  set(value: T): void;
}

/** A few choices side by side, as radio buttons. */
export function segmented<T extends string>(
  legend: string,
  choices: readonly (readonly [T, string])[],
  chosen: (value: T) => void,
): Choice<T> {
  const name = newId("choice");
  const inputs = choices.map(([value, label]) => {
    const input = h("input", { type: "radio", name, value });
    input.addEventListener("change", () => chosen(value));
    return { value, input, label: h("label", {}, input, h("span", {}, label)) };
  });
  return {
    element: h(
      "fieldset",
      { class: "segmented" },
      h("legend", {}, legend),
      h("div", {}, ...inputs.map(({ label }) => label)),
    ),
    set(value) {
      for (const item of inputs) item.input.checked = item.value === value;
    },
  };
}

export function select(
  label: string,
  options: readonly (readonly [string, string])[],
  chosen: (value: string) => void,
): { readonly element: HTMLElement; readonly input: HTMLSelectElement } {
  const id = newId("select");
  const input = h("select", { id });
  for (const [value, text] of options) input.append(h("option", { value }, text));
  input.addEventListener("change", () => chosen(input.value));
  return { element: h("div", { class: "field" }, h("label", { for: id }, label), input), input };
}

/** Hands a file to the visitor. */
export function download(blob: Blob, name: string): void {
  const url = URL.createObjectURL(blob);
  const link = h("a", { href: url, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
