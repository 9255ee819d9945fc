// A headset without a headset: IWER, loaded when asked for, in place of the browser's own WebXR.
// Mouse and keys move its hands; tests move them by script.

import type { XRDevice } from "iwer";
import { Quaternion, Vector3 } from "three";
import type { App } from "../app";
import type { Side } from "../protocol/types";
import { SIDES } from "../tracking/outlet";
import { EmulatorControls } from "./emulate-controls";

/** Where IWER's pinch closes, seen from the ray that its hands are placed by, m. */
const PINCH_FROM_RAY = new Vector3(0, -0.023, -0.01);
/** Where the head is, m, and how far it looks down, rad: seated, eyes on the table. */
const EYES = new Vector3(0, 1.2, 0);
const LOOK_DOWN = 0.5;

type HandInput = NonNullable<XRDevice["hands"][Side]>;

export class Emulator {
  readonly device: XRDevice;
  private readonly controls: EmulatorControls;
  /** How far each hand is pinched, 0 to 1. */
  private readonly pinches: Record<Side, number> = { left: 0, right: 0 };

  private constructor(
    device: XRDevice,
    private readonly app: App,
  ) {
    this.device = device;
    this.controls = new EmulatorControls(this);
  }

  static async install(app: App): Promise<Emulator> {
    const iwer = await import("iwer");
    const device = new iwer.XRDevice(iwer.metaQuest3);
    // Chromium has a WebXR of its own even without a headset: it is replaced.
    device.installRuntime({ forceInstall: true });
    device.primaryInputMode = "hand";
    device.position.set(EYES.x, EYES.y, EYES.z);
    device.quaternion.set(-Math.sin(LOOK_DOWN / 2), 0, 0, Math.cos(LOOK_DOWN / 2));
    const emulator = new Emulator(device, app);
    emulator.restHands();
    return emulator;
  }

  hand(side: Side): HandInput {
    const hand = this.device.hands[side];
    if (hand === undefined) throw new Error(`The emulated headset has no ${side} hand.`);
    return hand;
  }

  /** Both hands before the chest, as IWER's space has them. */
  restHands(): void {
    for (const side of SIDES) {
      const hand = this.hand(side);
      hand.position.set(side === "left" ? -0.18 : 0.18, EYES.y - 0.3, -0.3);
      hand.quaternion.set(0, 0, 0, 1);
      this.pinch(side, 0);
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
