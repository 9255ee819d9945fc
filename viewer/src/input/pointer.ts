// The pointer on the picture: dragging the hand moves it, dragging anything else moves the camera.
// Left drag moves it up, down and sideways, with Shift over the table; right drag or Alt turns. Two
// fingers: apart and together for depth, twisting to roll. The wheel over the hand closes it.

import { Quaternion, Ray, Raycaster, Vector2, Vector3 } from "three";
import type { App } from "../app";
import { dragNormal, dragStep, leanTowards } from "./drag-plane";
import { pickHand, type Picked } from "./pick";
import { POSING_ID, type Posing } from "./posing";
import { ControlHeld } from "./source";
import { aboveHold, holdPoint, placeOf, thingsOf } from "./things";

/** A press becomes a drag after so many pixels. */
const SLACK = 4;
/** rad per pixel */
const TURN = 0.008;
/** Share of the grasp per wheel unit (a notch is about 100). */
const WHEEL = 0.0006;
/** m per doubling of the fingers' distance */
const PINCH_DEPTH = 0.25;

interface Point {
  x: number;
  y: number;
}

export class PointerPosing {
  private readonly fingers = new Map<number, Point>();
  private picked: Picked | null = null;
  /** The point of the hand under the pointer, where the drag wants it, world frame, m. */
  private readonly grabbed = new Vector3();
  /** Of the upright plane: it stays as it is until the drag ends, so that the way back is the way. */
  private lean = 0;
  private dragging = false;
  private turning = false;
  private travelled = 0;
  private overHand = false;
  private hoverAt = 0;

  constructor(
    private readonly app: App,
    private readonly posing: Posing,
    private readonly refused: (reason: unknown) => void,
  ) {
    const { canvas } = app.stage;
    const capture = { capture: true } as const;
    canvas.addEventListener("pointerdown", (event) => this.down(event), capture);
    canvas.addEventListener("pointermove", (event) => this.move(event), capture);
    canvas.addEventListener("pointerup", (event) => this.up(event), capture);
    canvas.addEventListener("pointercancel", (event) => this.up(event), capture);
    canvas.addEventListener("wheel", (event) => this.wheel(event), { capture: true, passive: false });
    const byKeys = () => canvas.classList.remove("by-pointer");
    canvas.addEventListener("blur", byKeys);
    // A press need not have brought the focus: who comes by Tab afterwards sees the ring.
    document.addEventListener("keydown", ({ key }) => (key === "Tab" ? byKeys() : undefined), capture);
    app.feed.on("snapshot", () => (this.dragging ? this.mark() : undefined));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** The hand's bone under a place of the window. */
  pick(event: { clientX: number; clientY: number }): Picked | null {
    const { stage, feed } = this.app;
    if (feed.model === null || feed.snapshot === null || stage.renderer.xr.isPresenting) return null;
    return pickHand(this.rayAt(event.clientX, event.clientY), feed.model, feed.snapshot);
  }

  /** The pointer's ray in the world frame of the simulation. */
  private rayAt(clientX: number, clientY: number): Ray {
    const { stage } = this.app;
    const box = stage.canvas.getBoundingClientRect();
    const x = (2 * (clientX - box.left)) / box.width - 1;
    const y = 1 - (2 * (clientY - box.top)) / box.height;
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2(x, y), stage.camera);
    return new Ray().copy(caster.ray).applyMatrix4(stage.world.matrixWorld.clone().invert());
  }

  private down(event: PointerEvent): void {
    // The ring of the focus is for those who come by the Tab key.
    this.app.stage.canvas.classList.add("by-pointer");
    if (this.fingers.size > 0) {
      this.fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      this.capture(event);
      return;
    }
    if (event.button === 1) return;
    const picked = this.pick(event);
    if (picked === null) return;
    if (!this.mayPose()) {
      // The camera turns; the visitor learns why the hand does not come along.
      if (this.isHeld()) this.refused(new ControlHeld());
      return;
    }
    this.picked = picked;
    this.grabbed.copy(picked.point);
    this.dragging = false;
    this.turning = event.button === 2 || event.altKey;
    this.travelled = 0;
    this.fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    this.capture(event);
  }

  private capture(event: PointerEvent): void {
    const { canvas } = this.app.stage;
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    event.stopImmediatePropagation();
    event.preventDefault();
  }

  /** Dragging takes the hand from the script, not from another input or another viewer. */
  private mayPose(): boolean {
    const { inputs, connection, feed } = this.app;
    if (!feed.live || connection.state !== "open") return false;
    if (inputs.active !== null) return inputs.active.id === POSING_ID;
    const holder = connection.status?.control;
    return connection.inControl || holder === null;
  }

  /** Another viewer holds control of what is live here. */
  private isHeld(): boolean {
    const { connection, feed } = this.app;
    const recorded = (connection.status?.recording ?? null) !== null;
    const holder = connection.status?.control ?? null;
    return feed.live && !recorded && holder !== null && !connection.inControl;
  }

  private move(event: PointerEvent): void {
    const finger = this.fingers.get(event.pointerId);
    if (finger === undefined) {
      this.hover(event);
      return;
    }
    event.stopImmediatePropagation();
    const before = [...this.fingers.values()].map((point) => ({ ...point }));
    const from = { ...finger };
    const [dx, dy] = [event.clientX - finger.x, event.clientY - finger.y];
    finger.x = event.clientX;
    finger.y = event.clientY;
    this.travelled += Math.hypot(dx, dy);
    if (!this.dragging && this.travelled > SLACK) this.begin();
    if (!this.dragging || !this.posing.on) return;
    if (this.fingers.size > 1) this.pinch(before, [...this.fingers.values()]);
    else if (this.turning) this.turn(dx, dy);
    else this.shift(from, finger, event.shiftKey);
  }

  private begin(): void {
    const { inputs } = this.app;
    this.dragging = true;
    this.app.stage.canvas.style.cursor = "grabbing";
    if (this.picked !== null) this.posing.choose(this.picked.hand);
    this.lean = this.presentLean();
    this.mark();
    if (inputs.active !== null) return;
    inputs.start(POSING_ID).catch((error: unknown) => {
      this.fingers.clear();
      this.dragging = false;
      this.mark();
      this.refused(error);
    });
  }

  private up(event: PointerEvent): void {
    if (!this.fingers.delete(event.pointerId)) return;
    event.stopImmediatePropagation();
    if (this.fingers.size > 0) return;
    this.dragging = false;
    this.mark();
    this.app.stage.canvas.style.cursor = this.overHand ? "grab" : "";
  }

  /** The camera's axes in the world frame: right, up, into the picture. */
  private axes(): [Vector3, Vector3, Vector3] {
    const { camera, world } = this.app.stage;
    const toWorld = world.getWorldQuaternion(new Quaternion()).invert();
    const turn = toWorld.multiply(camera.getWorldQuaternion(new Quaternion()));
    const axis = (x: number, y: number, z: number) => new Vector3(x, y, z).applyQuaternion(turn);
    return [axis(1, 0, 0), axis(0, 1, 0), axis(0, 0, -1)];
  }

  /** How the drag that begins leads to what is under the hand. */
  private presentLean(): number {
    const { model, snapshot } = this.app.feed;
    const hand = this.posing.model;
    if (model === null || snapshot === null || hand === null) return 0;
    const places = thingsOf(model).flatMap((thing) => placeOf(thing, snapshot) ?? []);
    const [, , into] = this.axes();
    return leanTowards(holdPoint(hand, snapshot, true), places, into);
  }

  /** While it is dragged the hand shows what it is above. */
  private mark(): void {
    const { model, snapshot } = this.app.feed;
    const hand = this.posing.model;
    const shown = this.dragging && this.posing.on && model !== null && snapshot !== null && hand !== null;
    this.app.stage.markBelow(shown ? aboveHold(hand, snapshot) : null);
  }

  /** The grabbed point stays under the pointer. */
  private shift(from: Point, to: Point, level: boolean): void {
    const [before, after] = [this.rayAt(from.x, from.y), this.rayAt(to.x, to.y)];
    const view = this.grabbed.clone().sub(before.origin).normalize();
    const by = dragStep(before, after, this.grabbed, dragNormal(level ? "level" : "upright", view, this.lean));
    if (by === null) return;
    this.grabbed.add(by);
    this.posing.moveWrist(by);
  }

  private turn(dx: number, dy: number): void {
    const [right, up] = this.axes();
    const yaw = new Quaternion().setFromAxisAngle(up, dx * TURN);
    this.posing.turnWrist(yaw.multiply(new Quaternion().setFromAxisAngle(right, dy * TURN)));
  }

  private pinch(before: readonly Point[], after: readonly Point[]): void {
    const line = ([a, b]: readonly Point[]) => new Vector2(b.x - a.x, b.y - a.y);
    const [from, to] = [line(before), line(after)];
    if (from.length() < 1 || to.length() < 1) return;
    const [, , into] = this.axes();
    const nearer = Math.log2(to.length() / from.length()) * PINCH_DEPTH;
    const by = dragNormal("upright", into).multiplyScalar(-nearer);
    this.grabbed.add(by);
    this.posing.moveWrist(by);
    // The window's y runs down: a turn to the right there is one about the view's direction.
    const twist = Math.atan2(from.cross(to), from.dot(to));
    this.posing.turnWrist(new Quaternion().setFromAxisAngle(into, twist));
  }

  private wheel(event: WheelEvent): void {
    if (!this.posing.on || (!this.dragging && !this.overHand)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    const pixels = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? 1 : 33;
    const now = this.posing.sliders().grasp;
    this.posing.setGrasp(Math.min(1, Math.max(0, now + event.deltaY * pixels * WHEEL)));
  }

  private hover(event: PointerEvent): void {
    if (event.buttons !== 0 || event.timeStamp - this.hoverAt < 40) return;
    this.hoverAt = event.timeStamp;
    this.overHand = this.mayPose() && this.pick(event) !== null;
    this.app.stage.canvas.style.cursor = this.overHand ? "grab" : "";
  }
}
