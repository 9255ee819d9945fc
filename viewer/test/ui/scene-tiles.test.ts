// Every built-in scene has a small picture, and the pictures stay small.

import { readFileSync, readdirSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { expect, it } from "vitest";
import { MOMENTS } from "../../e2e/support/moments";
import { inOrder, pictureOf } from "../../src/ui/scene-tiles";

const folder = (path: string) => fileURLToPath(new URL(path, import.meta.url));
const scenes = readdirSync(folder("../../../crates/thenar-scene/scenes/"))
  .filter((name) => name.endsWith(".toml"))
  .map((name) => name.replace(".toml", ""))
  .sort();
const pictures = readdirSync(folder("../../src/ui/thumbs/")).sort();

/** Width and height of a lossy WebP, px (RFC 6386, 9.1: 14 bits each after the start code 9d 01 2a). */
function size(webp: Buffer): [number, number] {
  expect([webp.toString("latin1", 0, 4), webp.toString("latin1", 8, 12)]).toEqual(["RIFF", "WEBP"]);
  const start = webp.indexOf(Buffer.from([0x9d, 0x01, 0x2a]));
  expect(start).toBeGreaterThan(0);
  return [webp.readUInt16LE(start + 3) & 0x3fff, webp.readUInt16LE(start + 5) & 0x3fff];
}

it("has one picture for each built-in scene, and none beside", () => {
  expect(pictures).toEqual(scenes.map((name) => `${name}.webp`));
  expect(MOMENTS.map(({ scene }) => scene).sort()).toEqual(scenes);
  for (const scene of scenes) expect(pictureOf(scene)).toContain(scene);
  expect(pictureOf("of-my-own")).toBeNull();
});

it("keeps them small", () => {
  const all = pictures.map((name) => readFileSync(folder(`../../src/ui/thumbs/${name}`)));
  for (const webp of all) expect(size(webp)).toEqual([160, 100]);
  expect(all.reduce((sum, { length }) => sum + length, 0)).toBeLessThan(150_000);
});

it("puts scenes without a hand last", () => {
  const entries = ["falling-box", "fist", "gripper", "pen"].map((name) => ({ name, title: "" }));
  expect(inOrder(entries).map(({ name }) => name)).toEqual(["fist", "pen", "falling-box", "gripper"]);
});
