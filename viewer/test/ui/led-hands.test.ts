// The dock shows the hands that are led, whichever source leads them.

import { expect, it } from "vitest";
import type { Connection } from "../../src/net/connection";
import type { HandModel, Side } from "../../src/protocol/types";
import { PoseOutlet } from "../../src/tracking/outlet";
import { newHandJoints } from "../../src/tracking/joints";
import { fingertipForces } from "../../src/ui/grasp-dock";
import { handName, ledHands } from "../../src/ui/led-hands";

const hand = (name: string, side: Side | null) => ({ name, side }) as HandModel;
const BOTH = [hand("right", "right"), hand("left", "left")];

it("shows the hand of the side that is led, both where both are", () => {
  expect(ledHands(BOTH, ["left"], [])).toEqual([1]);
  expect(ledHands(BOTH, ["right"], [1])).toEqual([0]);
  expect(ledHands(BOTH, ["left", "right"], [1])).toEqual([0, 1]);
});

it("keeps the hand that was led while tracking is lost, and begins with the first", () => {
  expect(ledHands(BOTH, [], [1])).toEqual([1]);
  expect(ledHands(BOTH, [], [])).toEqual([0]);
  // A side that the scene lacks leads nothing.
  expect(ledHands([hand("hand", "right")], ["left"], [])).toEqual([0]);
  expect(ledHands([hand("hand", "right")], [], [1])).toEqual([0]);
  expect(ledHands([], ["left"], [])).toEqual([]);
});

it("shows a hand of no known side by its name, and leads it by none", () => {
  const unknown = [hand("claw", null), hand("left", "left")];
  expect(ledHands(unknown, ["left"], [])).toEqual([1]);
  expect(ledHands(unknown, [], [])).toEqual([0]);
  expect(handName(unknown[0]!)).toBe("claw");
});

it("shows every hand of a side, for a pose moves them all", () => {
  const twice = [hand("glove", "right"), hand("hand", "right")];
  expect(ledHands(twice, ["right"], [])).toEqual([0, 1]);
  expect(twice.map(handName)).toEqual(["Right hand: glove", "Right hand"]);
  // What the server names a hand that the scene lacked.
  expect(handName(hand("left hand", "left"))).toBe("Left hand");
  expect(BOTH.map(handName)).toEqual(["Right hand", "Left hand"]);
});

it("reads that hand's fingertips", () => {
  // Two hands of six digits with four numbers each; the force of the second hand's ring finger.
  const fingers = new Float32Array(48);
  fingers[24 + 4 * 4] = 3;
  expect(fingertipForces(fingers, 1)).toEqual([0, 0, 0, 3, 0]);
  expect(fingertipForces(fingers, 0)).toEqual([0, 0, 0, 0, 0]);
});

it("knows the sides that tracked poses move, until they are lost", () => {
  const line = { inControl: true, model: { hands: BOTH }, sendJoints: () => 1, sendLost: () => true };
  const outlet = new PoseOutlet(line as unknown as Connection);
  expect(outlet.led()).toEqual([]);
  outlet.joints("left", newHandJoints());
  expect(outlet.led()).toEqual(["left"]);
  outlet.joints("right", newHandJoints());
  outlet.lost("left");
  expect(outlet.led()).toEqual(["right"]);
  outlet.lostAll();
  expect(outlet.led()).toEqual([]);
});
