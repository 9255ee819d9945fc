// What the page says to a first visitor: what to do now, what to lift, what it takes.

import { describe, expect, it } from "vitest";
import { PER_DIGIT, PER_HAND, type SceneModel } from "../../src/protocol/types";
import { dropRefusal } from "../../src/ui/drops";
import { fingertipForces, forceText } from "../../src/ui/grasp-dock";
import { hintText } from "../../src/ui/hint";
import { heightOf, Lift, thingToLift } from "../../src/ui/lift";
import { loadingText } from "../../src/ui/loading";

describe("the hint", () => {
  it("names what closes the hand, for each pointer, before and while the visitor leads", () => {
    expect(hintText("mouse", false, "bread")).toMatch(/bread.*wheel/);
    expect(hintText("mouse", true, "bread")).toMatch(/wheel.*G.*slider/);
    expect(hintText("touch", false, "bread")).toContain("slider");
    expect(hintText("touch", true, "bread")).toMatch(/slider.*Two fingers/);
    for (const leading of [false, true]) expect(hintText("touch", leading, "bread")).not.toMatch(/wheel|Shift|key/);
  });

  it("speaks of no thing where there is none", () => {
    for (const leading of [false, true]) expect(hintText("mouse", leading, null)).not.toMatch(/null|up\./);
  });
});

/** Two hands' bones, a table, and what is given: enough of a model to look for things. */
function model(softs: object[], rigids: object[]): SceneModel {
  return { hands: [{}], softs, rigids } as unknown as SceneModel;
}

const TABLE = { name: "table", kind: "plane", fixed: true };
const BONE = { name: "palm", kind: "bone", fixed: false };
const FLESH = { name: "hand", hand: 0, node_start: 0, nodes: new Float32Array(6) };

describe("lifting", () => {
  it("finds the loaf among flesh and the car among bones", () => {
    const loaf = { name: "bread", hand: null, node_start: 2, nodes: new Float32Array(9) };
    expect(thingToLift(model([FLESH, loaf], [BONE, TABLE]))).toEqual({ name: "bread", soft: { start: 2, end: 5 }, rigid: null });
    const car = { name: "car", kind: "compound", fixed: false };
    expect(thingToLift(model([FLESH], [BONE, TABLE, car]))).toEqual({ name: "car", soft: null, rigid: 2 });
    expect(thingToLift(model([FLESH], [BONE, TABLE]))).toBeNull();
  });

  const car = { name: "car", soft: null, rigid: 1 };
  const moment = (height: number, force: number) => {
    const rigids = new Float32Array(14);
    rigids[8] = height;
    const fingers = new Float32Array(PER_HAND);
    fingers[PER_DIGIT] = force;
    return { rigids, fingers, nodes: new Float32Array(0) };
  };

  it("is seen when the hand holds the thing 20 mm above where it lay", () => {
    const lift = new Lift(car);
    expect(lift.seen(moment(0.03, 1))).toBe(false);
    expect(lift.seen(moment(0.049, 1))).toBe(false);
    expect(lift.seen(moment(0.051, 1))).toBe(true);
  });

  it("is not seen where the script had lifted it, or where it flies", () => {
    const held = new Lift(car);
    expect(held.seen(moment(0.09, 1))).toBe(false);
    expect(held.seen(moment(0.03, 1))).toBe(false);
    const flung = new Lift(car);
    flung.seen(moment(0.03, 0));
    expect(flung.seen(moment(0.09, 0))).toBe(false);
  });

  it("takes the mean height of flesh", () => {
    // Nodes 1 and 2, at 10 and 30 mm.
    const nodes = Float32Array.from([0, 9, 0, 0, 0.01, 0, 0, 0.03, 0]);
    const height = heightOf({ name: "bread", soft: { start: 1, end: 3 }, rigid: null }, { nodes, rigids: nodes });
    expect(height).toBeCloseTo(0.02, 7);
  });
});

describe("the dock", () => {
  it("shows the normal forces of thumb to little finger of the hand that is led", () => {
    const fingers = new Float32Array(2 * PER_HAND);
    for (let i = 0; i < fingers.length; i += PER_DIGIT) fingers[i] = i / PER_DIGIT;
    expect(fingertipForces(fingers, 0)).toEqual([1, 2, 3, 4, 5]);
    expect(fingertipForces(fingers, 1)).toEqual([7, 8, 9, 10, 11]);
  });

  it("keeps to three digits", () => {
    expect([0, 0.284, 9.994, 9.996, 12.34].map(forceText)).toEqual(["0.00 N", "0.28 N", "9.99 N", "10.0 N", "12.3 N"]);
  });
});

it("loading says what it waits for, and how much has come", () => {
  expect(loadingText(false, null)).toContain("Reaching");
  expect(loadingText(true, null)).toContain("Loading the model");
  expect(loadingText(true, 770_000)).toContain("770 kB");
});

it("a dropped file of another kind hears what the page takes", () => {
  const takers = ["a recording (.thenar-recording)", "a hand motion (.jsonl)"].map((what) => ({ what, pattern: /x/, open: () => undefined }));
  expect(dropRefusal("bread.stl", takers)).toBe(
    "The page takes a recording (.thenar-recording) or a hand motion (.jsonl); bread.stl is neither.",
  );
});
