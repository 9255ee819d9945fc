// Controllers as hands: where the wrist is, what buttons close, and what is not read.

import { Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { ANGLE_SPEED_MOST } from "../../src/input/hand-pose";
import { grasp } from "../../src/input/shapes";
import type { HandModel, Side } from "../../src/protocol/types";
import { identity } from "../../src/tracking/rigid";
import { XrControllers } from "../../src/xr/controllers";
import { LOST_AFTER_S } from "../../src/xr/hands";
import { Sizing, WAIT_S } from "../../src/xr/sizing";

const LENGTH = 0.2;
const hand = {
  length: LENGTH,
  angles: Array.from({ length: 20 }, () => ({ min: -3, max: 3, rest: 0 })),
} as unknown as HandModel;

interface Fake {
  readonly handedness: XRHandedness;
  readonly trigger?: number;
  readonly squeeze?: number;
  readonly stick?: boolean;
  /** No grip, as of a gaze or a screen. */
  readonly gripless?: boolean;
  readonly bare?: boolean;
}

const AT = new Vector3(0.1, 0.9, -0.3);
/** Thumb up, fingers ahead: x to the right, -z up, so that y points back. */
const TURN = new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), Math.PI / 2);

const space = {} as XRReferenceSpace;

function frame(sources: readonly Fake[], visibilityState: XRVisibilityState = "visible"): XRFrame {
  const inputs = sources.map(({ handedness, trigger = 0, squeeze = 0, stick = false, gripless, bare }) => ({
    handedness,
    hand: bare ? new Map() : undefined,
    gripSpace: gripless ? undefined : {},
    gamepad: { buttons: [{ value: trigger }, { value: squeeze }, { value: 0 }, { value: 0, pressed: stick }] },
  }));
  const fake = {
    session: { visibilityState, inputSources: inputs },
    getPose: () => ({ transform: { position: AT, orientation: TURN } }),
  };
  return fake as unknown as XRFrame;
}

const along = (rotation: Quaternion, axis: readonly [number, number, number]) =>
  new Vector3(...axis).applyQuaternion(rotation).toArray();
const near = (found: readonly number[], expected: readonly number[]) =>
  found.forEach((x, k) => expect(x).toBeCloseTo(expected[k], 9));

describe("controllers", () => {
  it("lie in the palms, which face each other", () => {
    const controllers = new XrControllers();
    controllers.read(frame([{ handedness: "left" }, { handedness: "right" }]), space, identity(), 0);
    const backs: readonly [Side, number][] = [
      ["right", 1],
      ["left", -1],
    ];
    for (const [side, back] of backs) {
      const { position, rotation } = controllers.pose(side, hand, 0);
      near(along(rotation, [0, 0, -1]), [0, 0, -1]);
      near(along(rotation, [0, 1, 0]), [back, 0, 0]);
      // The wrist is behind the handle, to the side of the back.
      near(position.toArray(), [AT.x + back * 0.13 * LENGTH, AT.y, AT.z + 0.42 * LENGTH]);
    }
  });

  it("are carried into the world", () => {
    const controllers = new XrControllers();
    const toWorld = { position: new Vector3(1, 2, 3), rotation: new Quaternion(0, 1, 0, 0) };
    controllers.read(frame([{ handedness: "right" }]), space, toWorld, 0);
    const { position, rotation } = controllers.pose("right", hand, 0);
    // A half turn about y: x and z change sign.
    near(along(rotation, [0, 0, -1]), [0, 0, 1]);
    near(position.toArray(), [1 - AT.x - 0.13 * LENGTH, 2 + AT.y, 3 - AT.z - 0.42 * LENGTH]);
  });

  it("close what each button is for", () => {
    const cases: readonly (readonly [number, number, readonly number[]])[] = [
      [0, 0, [0, 0, 0, 0, 0]],
      [1, 0, [1, 1, 0, 0, 0]],
      [0, 1, [1, 0, 1, 1, 1]],
      [0.4, 0.7, [0.7, 0.4, 0.7, 0.7, 0.7]],
    ];
    for (const [trigger, squeeze, digits] of cases) {
      const controllers = new XrControllers();
      controllers.read(frame([{ handedness: "right", trigger, squeeze }]), space, identity(), 0);
      const { angles } = controllers.pose("right", hand, 0);
      digits.forEach((amount, digit) =>
        near([...angles.subarray(4 * digit, 4 * digit + 4)], [...grasp(amount).subarray(4 * digit, 4 * digit + 4)]),
      );
    }
  });

  it("bend fingers no faster than a hand", () => {
    const controllers = new XrControllers();
    controllers.read(frame([{ handedness: "right" }]), space, identity(), 0);
    const before = controllers.pose("right", hand, 0).angles;
    controllers.read(frame([{ handedness: "right", trigger: 1, squeeze: 1 }]), space, identity(), 0.01);
    const after = controllers.pose("right", hand, 0.01).angles;
    const most = Math.max(...after.map((angle, i) => Math.abs(angle - before[i])));
    expect(most).toBeCloseTo(0.01 * ANGLE_SPEED_MOST, 9);
    let time = 0.01;
    for (; time < 0.5; time += 0.01) {
      controllers.read(frame([{ handedness: "right", trigger: 1, squeeze: 1 }]), space, identity(), time);
      controllers.pose("right", hand, time);
    }
    near([...controllers.pose("right", hand, time).angles], [...grasp(1)]);
  });

  it("are read with a grip, a side and no bare hand, while the page is seen", () => {
    const unread: readonly (readonly [Fake, XRVisibilityState])[] = [
      [{ handedness: "none" }, "visible"],
      [{ handedness: "right", gripless: true }, "visible"],
      [{ handedness: "right", bare: true }, "visible"],
      [{ handedness: "right" }, "visible-blurred"],
    ];
    for (const [fake, visibility] of unread) {
      const controllers = new XrControllers();
      controllers.read(frame([fake], visibility), space, identity(), 0);
      expect(controllers.fresh("right")).toBe(false);
      expect(controllers.lost("right", 0)).toBe(true);
    }
    const controllers = new XrControllers();
    controllers.read(frame([{ handedness: "right", trigger: NaN }]), space, identity(), 0);
    expect(controllers.pose("right", hand, 0).angles.every(Number.isFinite)).toBe(true);
    expect(controllers.lost("right", 0.9 * LOST_AFTER_S)).toBe(false);
    expect(controllers.lost("right", 1.1 * LOST_AFTER_S)).toBe(true);
  });

  it("call for the scene once per press of a stick", () => {
    const controllers = new XrControllers();
    const pressed = [false, true, true, false, true].map((stick, k) => {
      controllers.read(frame([{ handedness: "left", stick }]), space, identity(), 0.01 * k);
      return controllers.pressed();
    });
    expect(pressed).toEqual([false, true, false, false, true]);
  });
});

describe("hands for controllers", () => {
  it("are those of the model, both as soon as both are held", () => {
    const sizing = new Sizing();
    sizing.hold("right", 0);
    expect(sizing.wanted(0.5 * WAIT_S)).toBeNull();
    expect(sizing.wanted(1.1 * WAIT_S)).toEqual({ right: null });
    sizing.hold("left", 2 * WAIT_S);
    expect(sizing.wanted(2 * WAIT_S)).toEqual({ left: null, right: null });
  });
});
