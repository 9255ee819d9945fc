// A headset without a headset: IWER, loaded when asked for, in place of the browser's own WebXR.
// Mouse and keys move its hands or controllers; tests move them by script.

import type { XRDevice } from "iwer";
import { Matrix4, Quaternion, Vector3 } from "three";
import type { App } from "../app";
import type { Side } from "../protocol/types";
import { SIDES } from "../tracking/outlet";
import { EmulatorControls } from "./emulate-controls";

/** Where IWER's pinch closes, seen from the ray that its hands are placed by, m. */
const PINCH_FROM_RAY = new Vector3(0, -0.023, -0.01);
/** Where the head is, m, and how far it looks down, rad: seated, eyes on the table. */
const EYES = new Vector3(0, 1.2, 0);
const LOOK_DOWN = 0.5;
/** Turns a grip space so that the hand around it has its thumb up and its fingers ahead. */
const THUMB_UP = new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), Math.PI / 2);

type HandInput = NonNullable<XRDevice["hands"][Side]>;
type ControllerInput = NonNullable<XRDevice["controllers"][Side]>;
export type Button = "trigger" | "squeeze";

export class Emulator {
  readonly device: XRDevice;
  private readonly controls: EmulatorControls;
  /** How far each hand is pinched, 0 to 1. */
  private readonly pinches: Record<Side, number> = { left: 0, right: 0 };

  private constructor(
    device: XRDevice,
    /** Grip of each controller in its ray's frame, by which IWER places it. */
    private readonly grips: Record<Side, Matrix4>,
    private readonly app: App,
  ) {
    this.device = device;
    this.controls = new EmulatorControls(this);
  }

  static async install(app: App): Promise<Emulator> {
    const iwer = await import("iwer");
    const headset = iwer.metaQuest3;
    const device = new iwer.XRDevice(headset);
    // Chromium has a WebXR of its own even without a headset: it is replaced.
    device.installRuntime({ forceInstall: true });
    device.primaryInputMode = "hand";
    device.position.set(EYES.x, EYES.y, EYES.z);
    device.quaternion.set(-Math.sin(LOOK_DOWN / 2), 0, 0, Math.cos(LOOK_DOWN / 2));
    const layout = headset.controllerConfig?.layout;
    const grip = (side: Side) => new Matrix4().fromArray(layout?.[side]?.gripOffsetMatrix ?? new Matrix4().elements);
    const emulator = new Emulator(device, { left: grip("left"), right: grip("right") }, app);
    emulator.restHands();
    return emulator;
  }

  hand(side: Side): HandInput {
    const hand = this.device.hands[side];
    if (hand === undefined) throw new Error(`The emulated headset has no ${side} hand.`);
    return hand;
  }

  controller(side: Side): ControllerInput {
    const controller = this.device.controllers[side];
    if (controller === undefined) throw new Error(`The emulated headset has no ${side} controller.`);
    return controller;
  }

  /** Controllers are in the hands, or lie aside. */
  hold(controllers: boolean): void {
    this.device.primaryInputMode = controllers ? "controller" : "hand";
  }

  get holds(): boolean {
    return this.device.primaryInputMode === "controller";
  }

  /** What is moved on this side. */
  moved(side: Side): HandInput | ControllerInput {
    return this.holds ? this.controller(side) : this.hand(side);
  }

  /** Both hands before the chest, as IWER's space has them. */
  restHands(): void {
    for (const side of SIDES) {
      const hand = this.hand(side);
      hand.position.set(side === "left" ? -0.18 : 0.18, EYES.y - 0.3, -0.3);
      hand.quaternion.set(0, 0, 0, 1);
      this.pinch(side, 0);
      const controller = this.controller(side);
      controller.position.set(side === "left" ? -0.18 : 0.18, EYES.y - 0.3, -0.3);
      controller.quaternion.set(0, 0, 0, 1);
    }
  }

  /** Puts the place where the hand pinches at a point of the simulated world, m. */
  place(side: Side, x: number, y: number, z: number): void {
    const { world } = this.app.stage;
    const turn = new Quaternion().copy(world.quaternion);
    const ray = new Vector3(x, y, z).sub(PINCH_FROM_RAY).applyQuaternion(turn).add(world.position);
    const hand = this.hand(side);
    hand.position.set(ray.x, ray.y, ray.z);
    hand.quaternion.set(turn.x, turn.y, turn.z, turn.w);
  }

  /** Puts a controller's handle at a point of the simulated world, m, its thumb side up and fingers ahead. */
  grip(side: Side, x: number, y: number, z: number): void {
    const { world } = this.app.stage;
    const turn = new Quaternion().copy(world.quaternion).multiply(THUMB_UP);
    const controller = this.controller(side);
    const at = new Vector3(x, y, z).applyQuaternion(world.quaternion).add(world.position);
    const grip = new Matrix4().compose(at, turn, new Vector3(1, 1, 1));
    grip.multiply(this.grips[side].clone().invert()).decompose(at, turn, new Vector3());
    controller.position.set(at.x, at.y, at.z);
    controller.quaternion.set(turn.x, turn.y, turn.z, turn.w);
  }

  /** Presses a controller's button, 0 to 1. */
  press(side: Side, which: Button, value: number): void {
    this.controller(side).updateButtonValue(which, value);
  }

  /** 0 relaxed to 1 thumb on index. */
  pinch(side: Side, value: number): void {
    this.pinches[side] = value;
    this.hand(side).updatePinchValue(value);
  }

  pinchOf(side: Side): number {
    return this.pinches[side];
  }

  /** Hides a hand from the trackers, or shows it again. */
  show(side: Side, seen: boolean): void {
    this.hand(side).connected = seen;
  }

  /** For the time of a session: mouse and keys move the hands. Call what comes back at its end. */
  attach(leave: () => void): () => void {
    const { canvas } = this.app.stage;
    const [home, next] = [canvas.parentElement, canvas.nextSibling];
    const detach = this.controls.attach(this.device.canvasContainer, leave);
    return () => {
      detach();
      // IWER puts the canvas back as the last child, above the panels.
      setTimeout(() => home?.insertBefore(canvas, next), 0);
    };
  }
}
