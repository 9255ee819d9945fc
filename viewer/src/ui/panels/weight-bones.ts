// Chooses the bones whose skinning weights colour the skin.

import { DIGITS, type Digit, type HandBone } from "../../protocol/types";
import type { Desk } from "../desk";
import { h } from "../dom";
import { group } from "../widgets";

const titled = (digit: Digit) => digit[0].toUpperCase() + digit.slice(1);

export interface BoneChoice {
  readonly element: HTMLElement;
  show(on: boolean): void;
}

export function weightBones(desk: Desk): BoneChoice {
  const { feed, stage } = desk.app;
  const list = h("div", { class: "bone-choice" });
  const element = group(
    "Skinning weights of",
    h("p", { class: "help" }, "The weights of several bones are added."),
    list,
  );
  let listed = "";
  /** Hands of one make have the same bones: each name is offered once. */
  const fill = () => {
    const bones = new Map<string, HandBone>();
    for (const hand of feed.model?.hands ?? []) for (const bone of hand.bones) bones.set(bone.name, bone);
    const names = [...bones.keys()].join();
    if (names !== listed) list.replaceChildren(...DIGITS.flatMap((digit) => row(digit, bones)));
    listed = names;
    for (const box of list.querySelectorAll("input")) box.checked = stage.weightBones.includes(box.value);
  };
  const row = (digit: Digit, bones: ReadonlyMap<string, HandBone>) => {
    const own = [...bones.values()].filter((bone) => bone.digit === digit);
    if (own.length === 0) return [];
    const boxes = own.map((bone) => choice(bone.name, digit));
    return [h("div", { role: "group", "aria-label": titled(digit) }, h("b", {}, titled(digit)), ...boxes)];
  };
  const choice = (name: string, digit: Digit) => {
    const box = h("input", { type: "checkbox", value: name, "aria-label": name });
    box.addEventListener("change", () => {
      const others = stage.weightBones.filter((bone) => bone !== name);
      stage.setWeightBones(box.checked ? [...others, name] : others);
    });
    return h("label", { title: name }, box, h("span", {}, name.replace(`${digit}-`, "")));
  };
  const show = (on: boolean) => {
    element.hidden = !on;
    if (on) fill();
  };
  feed.on("model", fill);
  show(stage.layer("weights"));
  return { element, show };
}
