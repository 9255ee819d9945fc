// Scenes by what happens in them: their titles, those without a hand to lead in a group of their own.

import type { SceneEntry } from "../protocol/types";
import { h } from "./dom";

/** The built-in scenes that have no hand; a test holds this list against the scene files. */
export const WITHOUT_HAND: ReadonlySet<string> = new Set([
  "body",
  "falling-box",
  "finger-pendulum",
  "forearm",
  "gripper",
  "soft-cube",
]);

/** A title as a name: without the full stop; the file's name where there is no title. */
export function sceneName({ name, title }: SceneEntry): string {
  return title.trim().replace(/\.$/, "") || name;
}

/** Fills a menu; the values stay the scenes' names. */
export function fillSceneMenu(input: HTMLSelectElement, scenes: readonly SceneEntry[]): void {
  const option = (scene: SceneEntry) => h("option", { value: scene.name }, sceneName(scene));
  const bare = scenes.filter(({ name }) => WITHOUT_HAND.has(name));
  const group = bare.length === 0 ? [] : [h("optgroup", { label: "Without a hand" }, ...bare.map(option))];
  input.replaceChildren(...scenes.filter(({ name }) => !WITHOUT_HAND.has(name)).map(option), ...group);
}
