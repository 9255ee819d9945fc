// Controllers of an XR frame as hands: the grip says where the wrist is, the trigger and the grip button
// how far the fingers are bent.
//
// WebXR's grip space lies in the middle of a handle that the hand holds: -z along it to the thumb's side, +x out of
// the left palm and out of the back of the right hand. Open fingers then point along -y.

import { Matrix4, Quaternion, Vector3 } from "three";
import { ANGLE_SPEED_MOST, type HandPose } from "../input/hand-pose";
import { DIGIT_COUNT, clampAngles, grasp, type Angles } from "../input/shapes";
import type { HandModel, Side } from "../protocol/types";
import { SIDES } from "../tracking/outlet";
import type { Rigid } from "../tracking/rigid";
import { LOST_AFTER_S } from "./hands";

/** From the wrist to the middle of a held handle, in lengths of the hand: short of the knuckles, which are at 0.56 of it,
 * and below the palm. */
const HANDLE = new Vector3(0, -0.13, -0.42);
/** Buttons of WebXR's "xr-standard" gamepads. */
const TRIGGER = 0;
const SQUEEZE = 1;
const STICK = 3;

const axis = { x: new Vector3(1, 0, 0), y: new Vector3(0, 1, 0), z: new Vector3(0, 0, 1) };

/** The wrist frame (-z towards the fingers, +y out of the back) in the grip's. */
function wristInGrip(side: Side): Quaternion {
  const back = side === "right" ? axis.x.clone() : axis.x.clone().negate();
  const across = back.clone().cross(axis.y);
  return new Quaternion().setFromRotationMatrix(new Matrix4().makeBasis(across, back, axis.y));
}

interface Held {
  readonly wristInGrip: Quaternion;
  /** Grip in the simulated world. */
  readonly position: Vector3;
  readonly rotation: Quaternion;
  trigger: number;
  squeeze: number;
  stick: boolean;
  /** When it was last seen, s. */
  seen: number;
  fresh: boolean;
  /** Angles that have followed the buttons so far, and when, s. */
  angles: Angles | null;
  moved: number;
}

const held = (side: Side): Held => ({
  wristInGrip: wristInGrip(side),
  position: new Vector3(),
  rotation: new Quaternion(),
  trigger: 0,
  squeeze: 0,
  stick: false,
  seen: -Infinity,
  fresh: false,
  angles: null,
  moved: 0,
});

export class XrControllers {
  private readonly sides: Record<Side, Held> = { left: held("left"), right: held("right") };
  private stickBefore = false;

  /** Reads what the frame knows. `toWorld` takes the reference space to the simulated world. */
  read(frame: XRFrame, space: XRReferenceSpace, toWorld: Rigid, time: number): void {
    for (const side of SIDES) this.sides[side].fresh = false;
    if (frame.session.visibilityState !== "visible") return;
    for (const source of frame.session.inputSources) {
      const { hand, handedness, gripSpace, gamepad } = source;
      if (hand || handedness === "none" || !gripSpace || !gamepad) continue;
      const grip = frame.getPose(gripSpace, space)?.transform;
      if (!grip) continue;
      const into = this.sides[handedness];
      const { position: p, orientation: q } = grip;
      into.position.set(p.x, p.y, p.z).applyQuaternion(toWorld.rotation).add(toWorld.position);
      into.rotation.set(q.x, q.y, q.z, q.w).premultiply(toWorld.rotation).normalize();
      into.trigger = share(gamepad.buttons[TRIGGER]?.value);
      into.squeeze = share(gamepad.buttons[SQUEEZE]?.value);
      into.stick = gamepad.buttons[STICK]?.pressed ?? false;
      // Out of sight for a while, it begins with the fingers as the buttons say.
      if (time - into.seen > LOST_AFTER_S) into.angles = null;
      into.seen = time;
      into.fresh = true;
    }
  }

  fresh(side: Side): boolean {
    return this.sides[side].fresh;
  }

  lost(side: Side, time: number): boolean {
    return time - this.sides[side].seen > LOST_AFTER_S;
  }

  /** Pose of a hand that holds this controller: index finger by the trigger, the three others by the grip button, the
   * thumb by whichever is pressed farther. Fingers are no faster than a hand's. */
  pose(side: Side, hand: HandModel, time: number): HandPose {
    const from = this.sides[side];
    const goal = clampAngles(closed(from.trigger, from.squeeze), hand);
    const most = ANGLE_SPEED_MOST * Math.max(0, time - from.moved);
    const angles = from.angles;
    from.angles =
      angles === null ? goal : angles.map((angle, i) => angle + Math.min(most, Math.max(-most, goal[i] - angle)));
    from.moved = time;
    const rotation = from.rotation.clone().multiply(from.wristInGrip).normalize();
    const handle = HANDLE.clone().multiplyScalar(hand.length).applyQuaternion(rotation);
    return { position: from.position.clone().sub(handle), rotation, angles: from.angles };
  }

  /** True in the frame in which a stick is pressed. */
  pressed(): boolean {
    const now = SIDES.some((side) => this.sides[side].fresh && this.sides[side].stick);
    const before = this.stickBefore;
    this.stickBefore = now;
    return now && !before;
  }
}

/** Digits closed by so much: thumb, index finger, and the others. */
function closed(trigger: number, squeeze: number): Angles {
  const amounts = [Math.max(trigger, squeeze), trigger, squeeze, squeeze, squeeze];
  const angles = grasp(0);
  for (let digit = 0; digit < DIGIT_COUNT; digit++) {
    angles.set(grasp(amounts[digit]).subarray(4 * digit, 4 * digit + 4), 4 * digit);
  }
  return angles;
}

const share = (value: number | undefined): number =>
  value !== undefined && Number.isFinite(value) ? Math.min(1, Math.max(0, value)) : 0;
