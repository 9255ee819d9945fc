// Posing by keys held down: arrows move the wrist, Q and E lower and raise it, with Shift they turn
// it; A S D F and Space close the fingers as those of a left hand lie on them, with Shift they open.

import { Quaternion, Vector3 } from "three";
import type { App } from "../app";
import type { Keys } from "../ui/keys";
import { POSING_ID, type Posing } from "./posing";

/** m/s, rad/s, share of a finger's way per second. */
const MOVE = 0.18;
const TURN = 1.4;
const CURL = 1.6;

/** Key to digit: thumb to little. */
const FINGERS: Readonly<Record<string, number>> = { " ": 0, f: 1, d: 2, s: 3, a: 4 };
const ARROWS: Readonly<Record<string, readonly [number, number, number]>> = {
  arrowleft: [-1, 0, 0],
  arrowright: [1, 0, 0],
  arrowup: [0, 0, 1],
  arrowdown: [0, 0, -1],
  q: [0, -1, 0],
  e: [0, 1, 0],
};

export class PosingKeys {
  private readonly held = new Set<string>();
  private shift = false;

  constructor(
    private readonly app: App,
    private readonly posing: Posing,
    keys: Keys,
    private readonly refused: (reason: unknown) => void,
  ) {
    keys.addTaker((event, down) => this.take(event, down));
    window.addEventListener("blur", () => this.held.clear());
    posing.onTick = (dt) => this.tick(dt);
    const listed = (key: string, name: string, label: string) =>
      keys.add({ key, name, label, group: "Hand", act: () => undefined });
    keys.add({
      key: "m",
      label: "Take the hand by mouse and keys; give it back",
      group: "Hand",
      act: () => this.toggle(),
    });
    listed("hand:move", "← → ↑ ↓", "Move the wrist, as the camera sees it");
    listed("hand:height", "Q E", "Lower and raise the wrist");
    listed("hand:turn", "Shift with these", "Turn the wrist");
    listed("hand:curl", "A S D F Space", "Close little, ring, middle, index finger, thumb; with Shift open");
    listed("hand:grasp", "G", "Close the whole hand; with Shift open");
  }

  private toggle(): void {
    const { inputs } = this.app;
    if (inputs.active === this.posing) inputs.stop();
    else {
      inputs.start(POSING_ID).catch(this.refused);
    }
  }

  private take(event: KeyboardEvent, down: boolean): boolean {
    const key = event.key.toLowerCase();
    this.shift = event.shiftKey;
    if (!down) return this.held.delete(key);
    if (!this.posing.on || event.altKey || !(key in FINGERS || key in ARROWS || key === "g")) return false;
    this.held.add(key);
    return true;
  }

  private tick(dt: number): void {
    if (this.held.size === 0) return;
    const sense = this.shift ? -1 : 1;
    const sliders = this.posing.sliders();
    const move = new Vector3();
    for (const key of this.held) {
      const digit = FINGERS[key];
      if (digit !== undefined) this.posing.setCurl(digit, share(sliders.curls[digit] + sense * CURL * dt));
      else if (key === "g") this.posing.setGrasp(share(sliders.grasp + 0.5 * sense * CURL * dt));
      else move.add(new Vector3(...ARROWS[key]));
    }
    if (move.lengthSq() === 0) return;
    const [right, ahead] = this.ground();
    const up = new Vector3(0, 1, 0);
    if (this.shift) {
      const turn = new Quaternion();
      const about = (axis: Vector3, amount: number) =>
        turn.premultiply(new Quaternion().setFromAxisAngle(axis, amount * TURN * dt));
      about(up, -move.x);
      about(right, -move.z);
      about(ahead, move.y);
      this.posing.turnWrist(turn);
      return;
    }
    const way = right.multiplyScalar(move.x).addScaledVector(ahead, move.z).addScaledVector(up, move.y);
    this.posing.moveWrist(way.multiplyScalar(MOVE * dt));
  }

  /** To the right and ahead as the camera sees it, level. */
  private ground(): [Vector3, Vector3] {
    const { camera, world } = this.app.stage;
    const turn = world.getWorldQuaternion(new Quaternion()).invert();
    turn.multiply(camera.getWorldQuaternion(new Quaternion()));
    const right = new Vector3(1, 0, 0).applyQuaternion(turn).setY(0);
    if (right.lengthSq() < 1e-6) right.set(1, 0, 0);
    right.normalize();
    return [right, new Vector3(0, 1, 0).cross(right)];
  }
}

function share(value: number): number {
  return Math.min(1, Math.max(0, value));
}
