// Posing: shapes, limits, speeds, and reading the present pose back from bones placed by an
// independent forward kinematics.

import { Quaternion, Ray, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { clampPose, copyPose, follow, restPose } from "../../src/input/hand-pose";
import { pickHand } from "../../src/input/pick";
import { presentPose } from "../../src/input/present-pose";
import {
  PRESETS,
  between,
  clampAngles,
  curl,
  curlOf,
  fingersAre,
  grasp,
  graspOf,
  preset,
  presetOf,
  thumbAside,
  thumbLast,
} from "../../src/input/shapes";
import { decode } from "../../src/protocol/decode";
import type { SceneModel, Snapshot } from "../../src/protocol/types";
import { modelMessage, snapshotMessage, type Place } from "./world";

function world(place: Place, untracked = false): { model: SceneModel; snapshot: Snapshot } {
  const model = decode(modelMessage(), null, 0);
  if (model.kind !== "model") throw new Error("no model");
  const snapshot = decode(snapshotMessage({ place, untracked }), model.model, 0);
  if (snapshot.kind !== "snapshot") throw new Error("no snapshot");
  return { model: model.model, snapshot: snapshot.snapshot };
}

const turned = new Quaternion().setFromAxisAngle(new Vector3(1, 2, 3).normalize(), 1.1);
const somewhere = new Vector3(0.1, 0.2, -0.05);

describe("the present pose", () => {
  it("is read back from the bones, flexions and spreads alike", () => {
    for (const name of PRESETS) {
      const angles = preset(name);
      const place = { position: somewhere, rotation: turned, angles };
      for (const untracked of [false, true]) {
        const { model, snapshot } = world(place, untracked);
        const pose = presentPose(model.hands[0], snapshot);
        expect(pose.position.distanceTo(somewhere)).toBeLessThan(1e-6);
        expect(pose.rotation.angleTo(turned)).toBeLessThan(1e-3);
        const limited = clampAngles(angles, model.hands[0]);
        pose.angles.forEach((angle, i) => {
          // Quaternions travel in single precision.
          expect(Math.abs(angle - limited[i]), `${name} ${i}`).toBeLessThan(1e-5);
        });
      }
    }
  });
});

describe("shapes", () => {
  it("are told from the sliders that make them", () => {
    for (const amount of [0, 0.3, 1]) {
      expect(graspOf(grasp(amount))).toBeCloseTo(amount, 9);
      const angles = new Float64Array(20);
      for (let digit = 0; digit < 5; digit++) angles.set(curl(digit, amount), 4 * digit);
      for (let digit = 0; digit < 5; digit++) expect(curlOf(digit, angles)).toBeCloseTo(amount, 9);
    }
  });

  it("close every flexion of every finger as the grasp closes", () => {
    const [open, closed] = [grasp(0), grasp(1)];
    for (const i of [0, 2, 3, 4, 6, 7, 8, 10, 11, 12, 14, 15, 16, 18, 19]) {
      expect(closed[i]).toBeGreaterThan(open[i]);
    }
    expect(grasp(7)).toEqual(closed);
  });

  it("are the hand's own where the server knows them", () => {
    const { model } = world({ position: somewhere, rotation: turned, angles: new Float64Array(20) });
    const own = new Float64Array(20).fill(0.5);
    const hand = { ...model.hands[0], shapes: new Map([["fist", own]]) };
    expect(presetOf("fist", hand)).toEqual(own);
    expect(presetOf("fist", hand)).not.toBe(own);
    expect(presetOf("point", hand)).toEqual(preset("point"));
  });

  it("lay the thumb over fingers that have bent", () => {
    const fist = preset("fist");
    const aside = thumbAside(fist);
    expect(aside.slice(4)).toEqual(fist.slice(4));
    expect(aside[2]).toBeLessThan(fist[2]);
    expect(fingersAre(aside, fist)).toBe(true);
    expect(fingersAre(preset("open"), fist)).toBe(false);
    expect(PRESETS.filter(thumbLast)).toEqual(["fist", "point"]);
  });

  it("go past the thumb aside on the way to a fist and back", () => {
    const { model } = world({ position: somewhere, rotation: turned, angles: new Float64Array(20) });
    const hand = model.hands[0];
    const [open, fist] = [preset("open"), preset("fist")];
    expect(between("open", "fist", 0, hand)).toEqual(open);
    expect(between("open", "fist", 1, hand)).toEqual(fist);
    const late = between("open", "fist", 0.75, hand);
    expect(late.slice(0, 4)).toEqual(thumbAside(fist).slice(0, 4));
    expect(late[4]).toBeCloseTo(0.75 * fist[4], 9);
    expect(between("fist", "open", 0.25, hand).slice(0, 4)).toEqual(late.slice(0, 4));
    expect(between("open", "pinch", 0.5, hand)[0]).toBeCloseTo(0.5 * preset("pinch")[0], 9);
  });

  it("stay within the joints' limits, whatever is asked", () => {
    const { model } = world({ position: somewhere, rotation: turned, angles: new Float64Array(20) });
    const hand = model.hands[0];
    const asked = Float64Array.from({ length: 20 }, (_, i) => [NaN, 99, -99, Infinity][i % 4]);
    clampAngles(asked, hand).forEach((angle, i) => {
      const joint = hand.angles[i]!;
      expect(angle).toBeGreaterThanOrEqual(joint.min);
      expect(angle).toBeLessThanOrEqual(joint.max);
    });
    const lacking = { ...hand, angles: hand.angles.map((a, i) => (i === 4 ? null : a)) };
    expect(clampAngles(asked, lacking)[4]).toBe(0);
  });
});

describe("following", () => {
  const hand = world({ position: somewhere, rotation: turned, angles: new Float64Array(20) }).model.hands[0];

  it("moves no faster than 1.5 m/s and arrives", () => {
    const pose = restPose(hand);
    const goal = copyPose(pose);
    goal.position.x += 0.3;
    goal.rotation.copy(turned);
    goal.angles = preset("fist");
    const before = pose.position.clone();
    follow(pose, goal, 0.02);
    expect(pose.position.distanceTo(before)).toBeCloseTo(0.03, 12);
    for (let i = 0; i < 60; i++) follow(pose, goal, 0.02);
    expect(pose.position.distanceTo(goal.position)).toBe(0);
    expect(pose.rotation.angleTo(turned)).toBeLessThan(1e-6);
    expect(Array.from(pose.angles)).toEqual(Array.from(goal.angles));
  });

  it("refuses numbers that are none and stays in reach", () => {
    const safe = restPose(hand);
    const goal = copyPose(safe);
    goal.position.set(NaN, 0, 0);
    goal.rotation.set(0, 0, 0, 0);
    clampPose(goal, hand, safe);
    expect(goal.position.equals(safe.position)).toBe(true);
    expect(goal.rotation.length()).toBeCloseTo(1, 12);
    goal.position.set(0, 30, 40);
    clampPose(goal, hand, safe);
    expect(goal.position.length()).toBeCloseTo(1, 12);
  });
});

describe("picking", () => {
  const { model, snapshot } = world({
    position: new Vector3(),
    rotation: new Quaternion(),
    angles: new Float64Array(20),
  });

  it("finds the finger under the ray, and nothing beside the hand", () => {
    // Straight down on the middle of the index finger's first bone, at -x, 95 + 22 mm ahead.
    const down = new Ray(new Vector3(-0.025, 0.5, -0.117), new Vector3(0, -1, 0));
    const picked = pickHand(down, model, snapshot);
    expect(model.hands[0].bones[picked!.bone].digit).toBe("index");
    expect(picked!.distance).toBeCloseTo(0.5, 2);
    const beside = new Ray(new Vector3(0.2, 0.5, -0.1), new Vector3(0, -1, 0));
    expect(pickHand(beside, model, snapshot)).toBeNull();
  });
});
