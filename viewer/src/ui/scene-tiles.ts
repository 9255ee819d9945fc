// The scenes as small pictures with their names, to choose from. The pictures are made by `npm run thumbs`.

import type { SceneEntry } from "../protocol/types";
import { h } from "./dom";
import "./scene-tiles.css";
import { WITHOUT_HAND, sceneName } from "./scene-menu";

const PICTURES = import.meta.glob<string>("./thumbs/*.webp", { eager: true, query: "?url", import: "default" });

/** The address of a scene's picture; a scene that did not come with the page has none. */
export function pictureOf(scene: string): string | null {
  return PICTURES[`./thumbs/${scene}.webp`] ?? null;
}

/** Scenes with a hand to lead first. */
export function inOrder(scenes: readonly SceneEntry[]): SceneEntry[] {
  const bare = (scene: SceneEntry) => WITHOUT_HAND.has(scene.name);
  return [...scenes.filter((scene) => !bare(scene)), ...scenes.filter(bare)];
}

export interface SceneTiles {
  readonly element: HTMLElement;
  fill(scenes: readonly SceneEntry[]): void;
  /** Marks the scene that runs. */
  mark(scene: string): void;
}

export function sceneTiles(chosen: (scene: string) => void): SceneTiles {
  const element = h("div", { class: "scene-tiles", role: "group", "aria-label": "Scenes in pictures" });
  const tile = (scene: SceneEntry): HTMLElement => {
    const [name, src] = [sceneName(scene), pictureOf(scene.name)];
    const size = { width: 160, height: 100 };
    // The picture's text names the button; what stands below is the same for those who see it.
    const picture = src === null ? h("span", { class: "no-picture" }) : h("img", { src, alt: name, ...size, loading: "lazy" });
    const caption = h("span", src === null ? {} : { "aria-hidden": "true" }, name);
    const act = () => chosen(scene.name);
    return h("button", { type: "button", "data-scene": scene.name, "aria-pressed": "false", onclick: act }, picture, caption);
  };
  return {
    element,
    fill: (scenes) => element.replaceChildren(...inOrder(scenes).map(tile)),
    mark(scene) {
      for (const button of element.querySelectorAll("[data-scene]")) {
        button.setAttribute("aria-pressed", String(button.getAttribute("data-scene") === scene));
      }
    },
  };
}
