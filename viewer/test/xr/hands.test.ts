// Hands of XR frames: read whole or not at all, carried into the world, lost after a while.

import { Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { LOST_AFTER_S, XrHands } from "../../src/xr/hands";
import { digitForces, FORCE_FULL, forceShare, totalForce } from "../../src/xr/forces";
import { Sizing, WAIT_S } from "../../src/xr/sizing";
import { identity } from "../../src/tracking/rigid";
import { straightHand, storedHand } from "../tracking/hands";
import type { SceneModel, Snapshot } from "../../src/protocol/types";

interface Fake {
  readonly handedness: XRHandedness;
  readonly whole: boolean;
}

const space = {} as XRReferenceSpace;
const handOf = new Map<string, XRHand>();

/** The parts of an XR frame that are read. */
function frame(sources: readonly Fake[], visibilityState: XRVisibilityState = "visible"): XRFrame {
  const inputs = sources.map(({ handedness, whole }) => {
    const key = `${handedness} ${whole}`;
    const made = handOf.get(key) ?? (new Map(Array.from({ length: 25 }, (_, i) => [i, { whole, handedness }])) as unknown as XRHand);
    handOf.set(key, made);
    return { handedness, hand: made };
  });
  type Joint = { whole: boolean; handedness: "left" | "right" };
  const fake = {
    session: { visibilityState, inputSources: inputs },
    fillPoses(spaces: Joint[], _base: unknown, out: Float32Array) {
      if (!spaces[0].whole) return false;
      out.set(storedHand(spaces[0].handedness, "relaxed").matrices);
      return true;
    },
    fillJointRadii(spaces: Joint[], out: Float32Array) {
      out.set(storedHand(spaces[0].handedness, "relaxed").radii);
      return spaces[0].whole;
    },
  };
  return fake as unknown as XRFrame;
}

describe("reading", () => {
  it("reads both hands into the world", () => {
    const hands = new XrHands();
    const toWorld = { position: new Vector3(1, 2, 3), rotation: new Quaternion(0, 1, 0, 0) };
    hands.read(frame([{ handedness: "left", whole: true }, { handedness: "right", whole: true }]), space, toWorld, 0);
    const { matrices } = storedHand("right", "relaxed");
    // A half turn about y: x and z change sign.
    const expected = [1 - matrices[12], 2 + matrices[13], 3 - matrices[14]];
    const right = hands.fresh("right");
    expected.forEach((x, k) => expect(right?.[k]).toBeCloseTo(x, 5));
    expect(hands.fresh("left")).not.toBeNull();
  });

  it("takes a hand whole or not at all, and calls it lost only after a while", () => {
    const hands = new XrHands();
    hands.read(frame([{ handedness: "left", whole: true }]), space, identity(), 1);
    hands.read(frame([{ handedness: "left", whole: false }]), space, identity(), 1.05);
    expect(hands.fresh("left")).toBeNull();
    expect(hands.lost("left", 1.05)).toBe(false);
    expect(hands.lost("left", 1 + LOST_AFTER_S + 0.01)).toBe(true);
    expect(hands.lost("right", 1)).toBe(true);
  });

  it("reads nothing while something else has the visitor's attention", () => {
    const hands = new XrHands();
    hands.read(frame([{ handedness: "left", whole: true }], "visible-blurred"), space, identity(), 1);
    expect(hands.fresh("left")).toBeNull();
  });
});

describe("asking for hands", () => {
  const hand = straightHand([0.14, 0.184, 0.19, 0.179, 0.159], 0.0075);
  const watch = (sizing: Sizing, side: "left" | "right", from: number) => {
    for (let i = 0; i <= 40; i++) sizing.add(side, hand, from + i * 0.03);
  };

  it("asks for both once both are measured", () => {
    const sizing = new Sizing();
    watch(sizing, "left", 0);
    expect(sizing.wanted(1.2)).toBeNull();
    watch(sizing, "right", 1);
    expect(Object.keys(sizing.wanted(2.2) ?? {})).toEqual(["left", "right"]);
    expect(Math.abs((sizing.wanted(2.2)?.left ?? 0) - 0.19)).toBeLessThan(0.003);
  });

  it("asks for one if the other stays away", () => {
    const sizing = new Sizing();
    watch(sizing, "left", 0);
    expect(Object.keys(sizing.wanted(1.2 + WAIT_S) ?? {})).toEqual(["left"]);
  });
});

describe("forces", () => {
  const model = { hands: [{ side: "right" }, { side: "left" }] } as unknown as SceneModel;
  const fingers = Float32Array.from({ length: 48 }, (_, i) => i);
  const snapshot = { fingers } as unknown as Snapshot;

  it("takes the normal force of each digit of the right side", () => {
    expect(digitForces(model, snapshot, "right")).toEqual([0, 4, 8, 12, 16, 20]);
    expect(digitForces(model, snapshot, "left")).toEqual([24, 28, 32, 36, 40, 44]);
    expect(totalForce(model, snapshot, "right")).toBe(60);
    expect(digitForces({ hands: [] } as unknown as SceneModel, snapshot, "left")).toBeNull();
    expect(totalForce(null, null, "left")).toBe(0);
  });

  it("goes from nothing to full", () => {
    expect([0, FORCE_FULL / 4, FORCE_FULL, 99].map(forceShare)).toEqual([0, 0.5, 1, 1]);
  });
});
