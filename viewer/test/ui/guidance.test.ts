// What the page says to a first visitor: what to do now, what to lift, what it takes.

import { Matrix4, Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { decode } from "../../src/protocol/decode";
import { PER_DIGIT, PER_HAND, type SceneModel } from "../../src/protocol/types";
import { aboveHold, holdPoint, placeOf, thingsOf } from "../../src/input/things";
import { dropRefusal } from "../../src/ui/drops";
import { fingertipForces, forceText } from "../../src/ui/grasp-dock";
import { hintText } from "../../src/ui/hint";
import { Lift, nextStep } from "../../src/ui/lift";
import { loadingText } from "../../src/ui/loading";
import { modelMessage, snapshotMessage } from "./world";

const STEPS = ["take", "reach", "close", "lift"] as const;

describe("the hint", () => {
  it("names what closes the hand, for each pointer, before and while the visitor leads", () => {
    expect(hintText("mouse", "take", "bread")).toMatch(/bread.*wheel/);
    expect(hintText("mouse", "reach", "bread")).toMatch(/down to the bread.*wheel.*G.*slider/);
    expect(hintText("mouse", "close", "bread")).toMatch(/round the bread.*wheel.*G.*slider/);
    expect(hintText("mouse", "lift", "bread")).toMatch(/hold the bread.*up.*[Ww]heel/);
    for (const step of ["reach", "close"] as const) expect(hintText("touch", step, "bread")).toMatch(/slider.*Two fingers/);
    for (const step of STEPS) {
      expect(hintText("touch", step, "bread")).toContain("slider");
      expect(hintText("touch", step, "bread")).not.toMatch(/[Ww]heel|Shift|key/);
    }
  });

  it("speaks of no thing where there is none", () => {
    for (const step of ["take", "close"] as const) expect(hintText("mouse", step, null)).not.toMatch(/null|up\./);
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
    expect(thingsOf(model([FLESH, loaf], [BONE, TABLE]))).toEqual([{ name: "bread", soft: { start: 2, end: 5 }, rigid: null }]);
    const car = { name: "car", kind: "compound", fixed: false };
    expect(thingsOf(model([FLESH], [BONE, TABLE, car]))).toEqual([{ name: "car", soft: null, rigid: 2 }]);
    expect(thingsOf(model([FLESH], [BONE, TABLE]))).toEqual([]);
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
    const at = placeOf({ name: "bread", soft: { start: 1, end: 3 }, rigid: null }, { nodes, rigids: nodes });
    expect(at?.y).toBeCloseTo(0.02, 7);
  });
});

describe("the next step", () => {
  /** A hand that points along -z above a box at (0, 20 mm, 0), its wrist where the hold is `above` over the box. */
  const moment = (above: number, thumb: number, index: number) => {
    const rest = decode(modelMessage(), null, 0);
    if (rest.kind !== "model") throw new Error("no model");
    // The hold is 0.54 lengths before the wrist, 0.34 below it and 0.11 to the thumb's side, -x; this hand is 0.19 m long.
    const position = new Vector3(0.11 * 0.19, 0.34 * 0.19 + 0.02 + above, 0.54 * 0.19);
    const fingers = new Float32Array(PER_HAND);
    fingers[PER_DIGIT] = thumb;
    fingers[2 * PER_DIGIT] = index;
    const place = { position, rotation: new Quaternion(), angles: new Float64Array(20) };
    const now = decode(snapshotMessage({ place, fingers }), rest.model, 0);
    if (now.kind !== "snapshot") throw new Error("no snapshot");
    return { model: rest.model, snapshot: now.snapshot };
  };
  const step = (above: number, thumb: number, index: number, before: "reach" | "close" = "reach") => {
    const { model, snapshot } = moment(above, thumb, index);
    return nextStep(0, thingsOf(model)[0], model, snapshot, before);
  };

  it("has the hold where a hand grips: a finger's breadth from the loaf's middle, where its scene takes the loaf", () => {
    const { model } = moment(0.1, 0, 0);
    // The wrist of bread-grasp as its fingers close; the loaf is 56 mm high.
    const fingers = new Vector3(-0.787, -0.147, -0.599).normalize();
    const back = new Vector3(-0.108, 0.989, -0.1);
    const rotation = new Quaternion().setFromRotationMatrix(
      new Matrix4().lookAt(new Vector3(), fingers, back),
    );
    const place = { position: new Vector3(0.072, 0.105, 0.041), rotation, angles: new Float64Array(20) };
    const now = decode(snapshotMessage({ place }), model, 0);
    if (now.kind !== "snapshot") throw new Error("no snapshot");
    const hold = holdPoint(model.hands[0], now.snapshot, true);
    expect(hold.distanceTo(new Vector3(0, 0.028, 0))).toBeLessThan(0.02);
  });

  it("is shown by a line from the flat hand's own height, straight above the hold", () => {
    const { model, snapshot } = moment(0.1, 0, 0);
    const [top, hold] = [aboveHold(model.hands[0], snapshot), holdPoint(model.hands[0], snapshot, false)];
    expect([top.x, top.z]).toEqual([hold.x, hold.z]);
    // The fingers of this hand lie level at its wrist's height, 0.34 of 0.19 m above the hold at 120 mm.
    expect(top.y).toBeCloseTo(0.12 + 0.34 * 0.19, 6);
  });

  it("is to go down, to close, and to lift, as the hand comes on", () => {
    expect(step(0.1, 0, 0)).toBe("reach");
    expect(step(0.04, 0, 0)).toBe("close");
    // One finger pushes, it does not hold.
    expect(step(0, 0, 1)).toBe("close");
    expect(step(0, 1, 1)).toBe("lift");
    // Fingers that press on each other, far off, hold nothing.
    expect(step(0.1, 1, 1)).toBe("reach");
  });

  it("does not flicker at the edge", () => {
    expect([step(0.06, 0, 0, "reach"), step(0.06, 0, 0, "close")]).toEqual(["reach", "close"]);
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
