// Skinning weights on the drawn skin, worked out by hand for one tetrahedron.

import { expect, it } from "vitest";
import { surfaceWeights } from "../src/scene/weights";
import type { Skin, SoftModel, Surface } from "../src/protocol/types";

const surface: Surface = {
  tets: Uint32Array.of(0, 0, 0),
  // A node, the middle of the tetrahedron, and the middle of an edge.
  weights: Float32Array.of(1, 0, 0, 0, 0.25, 0.25, 0.25, 0.25, 0, 0, 0.5, 0.5),
  triangles: Uint32Array.of(0, 1, 2),
  colours: null,
};
const soft: SoftModel = {
  name: "flesh",
  look: "skin",
  colour: null,
  hand: 0,
  node_start: 0,
  nodes: Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1),
  tets: Uint32Array.of(0, 1, 2, 3),
  render: surface,
  collision: surface,
  skin: null,
};
const skin: Skin = {
  bones: Uint16Array.of(7, 8, 7, 8, 8, 9, 9, 7),
  weights: Float32Array.of(1, 0, 0.5, 0.5, 0.75, 0.25, 1, 0),
  offsets: new Float32Array(24),
};

function of(...bones: number[]): number[] {
  const out = new Float32Array(3);
  surfaceWeights(soft, skin, new Set(bones), out);
  return Array.from(out);
}

it("weights of bones travel from the nodes to the skin", () => {
  // Bone 7 has 1, 0.5, 0, 0 at the nodes; bone 8 has 0, 0.5, 0.75, 0; bone 9 has 0, 0, 0.25, 1.
  expect(of(7)).toEqual([1, 0.375, 0]);
  expect(of(8)).toEqual([0, 0.3125, 0.375]);
  expect(of(9)).toEqual([0, 0.3125, 0.625]);
});

it("the weights of all bones add up to one, those of none to nothing", () => {
  expect(of(7, 8, 9)).toEqual([1, 1, 1]);
  expect(of()).toEqual([0, 0, 0]);
});
