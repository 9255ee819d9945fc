// The scene menu sorts scenes as the scene files have it.

import { readdirSync, readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { expect, it } from "vitest";
import { sceneName, WITHOUT_HAND } from "../../src/ui/scene-menu";

const folder = fileURLToPath(new URL("../../../crates/thenar-scene/scenes/", import.meta.url));

it("knows which built-in scenes have no hand to lead", () => {
  const files = readdirSync(folder).filter((name) => name.endsWith(".toml"));
  const bare = files.filter((name) => !/^\[\[hand\]\]/m.test(readFileSync(folder + name, "utf8")));
  expect(bare.length).toBeGreaterThan(0);
  expect([...WITHOUT_HAND].sort()).toEqual(bare.map((name) => name.replace(".toml", "")).sort());
});

it("calls a scene by its title, or by its file where it has none", () => {
  expect(sceneName({ name: "fist", title: "A hand closes to a fist and opens again." })).toBe(
    "A hand closes to a fist and opens again",
  );
  expect(sceneName({ name: "mine", title: "" })).toBe("mine");
});
