// What presses on the bodies of a scene without a hand; sums worked out by hand.

import { expect, it } from "vitest";
import { SOFT_BODY, type Contacts, type SceneModel } from "../../src/protocol/types";
import { BODIES_MOST, BodyLoads } from "../../src/ui/body-loads";
import { handlessText } from "../../src/ui/panels/forces";
import { QUANTITIES, bodyParts } from "../../src/ui/quantities";

type Bodies = Pick<SceneModel, "softs" | "rigids">;

/** Rigid bodies as name:kind, "!" for fixed ones. */
function scene(softs: string[], rigids: string[]): Bodies {
  const rigid = (text: string) => {
    const [name, kind] = text.replace("!", "").split(":");
    return { name, kind, fixed: text.endsWith("!") };
  };
  return { softs: softs.map((name) => ({ name })), rigids: rigids.map(rigid) } as unknown as Bodies;
}

const GRIPPER = scene(["gripper"], ["table:plane!", "ball:sphere", "gripper/palm:cylinder!", "gripper/finger:cylinder"]);

interface Touch {
  readonly a: number;
  readonly b: number;
  /** On A; the normal is +y. */
  readonly force: readonly [number, number, number];
  readonly area: number;
}

function contacts(all: readonly Touch[]): Contacts {
  return {
    count: all.length,
    bodyA: (i) => all[i].a,
    bodyB: (i) => all[i].b,
    force: (i, out) => void Object.assign(out, { x: all[i].force[0], y: all[i].force[1], z: all[i].force[2] }),
    normalForce: (i) => all[i].force[1],
    area: (i) => all[i].area,
  } as Contacts;
}

function sums(bodies: Bodies, all: readonly Touch[]): number[][] {
  const loads = new BodyLoads(bodies);
  const out = new Float32Array(4 * loads.names.length).fill(7);
  loads.sums({ contacts: contacts(all) }, out);
  return loads.names.map((_, k) => Array.from(out.subarray(4 * k, 4 * k + 4)));
}

it("lists flesh and loose bodies, not what is fixed nor the bones of a figure", () => {
  expect(new BodyLoads(GRIPPER).names).toEqual(["gripper", "ball"]);
  expect(new BodyLoads(scene([], ["hinge:none", "floor:plane!"])).names).toEqual([]);
});

it("adds normal and shear force, area and pressure of each body", () => {
  const [flesh, ball, table] = [SOFT_BODY, 1, 0];
  const [gripper, held] = sums(GRIPPER, [
    { a: flesh, b: ball, force: [0, 4, 3], area: 2e-4 },
    { a: ball, b: flesh, force: [0, 2, 0], area: 1e-4 },
    // A finger's bone presses through: force without an area, on the gripper's row.
    { a: 3, b: ball, force: [1, 1, 0], area: 0 },
    { a: ball, b: table, force: [0, 5, 0], area: 0 },
  ]);
  [7, 4, 3e-4, 6 / 3e-4].forEach((value, k) => expect(gripper[k] / value).toBeCloseTo(1, 5));
  [12, 4, 3e-4, 6 / 3e-4].forEach((value, k) => expect(held[k] / value).toBeCloseTo(1, 5));
});

it("leaves out what a body does to itself, and shows zeros where nothing touches", () => {
  expect(sums(GRIPPER, [{ a: SOFT_BODY, b: 3, force: [0, 9, 0], area: 1e-4 }])).toEqual([
    [0, 0, 0, 0],
    [0, 0, 0, 0],
  ]);
  expect(sums(GRIPPER, [])).toEqual([
    [0, 0, 0, 0],
    [0, 0, 0, 0],
  ]);
});

it("keeps to the plot's columns, and says what is left out", () => {
  const many = new BodyLoads(scene([], Array.from({ length: BODIES_MOST + 3 }, (_, i) => `b${i}:box`)));
  expect(many.names.length).toBe(BODIES_MOST);
  expect(handlessText(many)).toContain("3 more are left out");
  expect(handlessText(new BodyLoads(scene([], [])))).toBe("This scene has no hand, and nothing in it touches.");
  const parts = bodyParts(many.names);
  expect(new Set(parts.map(({ colour, dashed }) => `${colour} ${dashed}`)).size).toBe(BODIES_MOST);
  expect(QUANTITIES[1].curves(0, parts).map(({ column }) => column)).toEqual(parts.map((_, i) => 4 * i + 1));
});
