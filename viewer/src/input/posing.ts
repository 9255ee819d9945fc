// Posing the hand by mouse, touch, keys and sliders: a goal that these move, and a pose that
// follows it no faster than a hand could and goes to the server 60 times a second.

import type { Quaternion, Vector3 } from "three";
import type { App } from "../app";
import type { HandModel, Side } from "../protocol/types";
import { clampPose, copyPose, follow, wristNumbers, type HandPose } from "./hand-pose";
import { presentPose } from "./present-pose";
import {
  DIGIT_COUNT,
  clampAngles,
  curl,
  curlOf,
  fingersAre,
  grasp,
  graspOf,
  presetOf,
  setSpread,
  spreadOf,
  thumbAside,
  thumbLast,
  type Angles,
  type Preset,
} from "./shapes";
import { InputSourceBase } from "./source";

/** Between two messages, ms. The server takes a hand that says nothing for lost. */
const INTERVAL = 1000 / 60;
/** After a pause of the page (a hidden tab) the hand goes on, but does not leap, s. */
const DT_MOST = 0.05;

export const POSING_ID = "mouse";

export interface Sliders {
  readonly grasp: number;
  /** Thumb to little finger. */
  readonly curls: readonly number[];
  readonly spread: number;
}

export class Posing extends InputSourceBase {
  readonly id = POSING_ID;
  readonly label = "Mouse, touch and keys";
  readonly help =
    "Mouse: drag the hand up, down and sideways; with Shift over the table; right-drag (or Alt) turns it; the wheel " +
    "over it closes it. Touch: drag with one finger; two fingers apart bring it nearer, a twist rolls it; the " +
    "slider closes it.";
  /** Sliders, made where the panels are. */
  controls?: HTMLElement;
  /** Which of the scene's hands. */
  hand = 0;
  /** Called with the time since the last call, s, before each message: keys held act here. */
  onTick: ((dt: number) => void) | null = null;
  private goal: HandPose | null = null;
  private pose: HandPose | null = null;
  private timer: ReturnType<typeof setInterval> | undefined;
  private before = 0;
  /** The shape whose thumb waits for the fingers. */
  private closed: Angles | null = null;

  constructor(private readonly app: App) {
    super();
    const { connection, feed } = app;
    feed.on("model", (model) => {
      this.forget();
      this.hand = Math.min(this.hand, Math.max(0, model.hands.length - 1));
      this.setAvailable(model.hands.length > 0, model.hands.length > 0 ? "" : "This scene has no hand.");
    });
    // Another server, or another's control: what was posed is void.
    connection.on("close", () => {
      this.forget();
    });
    connection.on("status", () => {
      if (this.state !== "on" || connection.inControl || connection.status?.control === null) return;
      this.end("Another viewer took control.");
    });
    feed.on("live", (live) => {
      if (!live && this.state === "on") this.end("A recording is shown.");
    });
  }

  /** The hand that is posed, if the scene has one. */
  get model(): HandModel | null {
    return this.app.feed.model?.hands[this.hand] ?? null;
  }

  get on(): boolean {
    return this.state === "on";
  }

  start(): void {
    if (this.model === null) throw new Error("This scene has no hand to pose.");
    if (this.model.side === null) throw new Error("This hand's model says neither left nor right: poses do not move it.");
    if (!this.app.feed.live) throw new Error("A recording is shown. Go back to live first.");
    this.before = performance.now();
    this.timer = setInterval(() => this.tick(), INTERVAL);
    this.set("on");
  }

  led(): readonly Side[] {
    const side = this.model?.side ?? null;
    return this.on && side !== null ? [side] : [];
  }

  stop(): void {
    if (this.state === "on") this.end("");
  }

  private end(note: string): void {
    clearInterval(this.timer);
    const side = this.model?.side ?? null;
    if (side !== null && this.app.connection.inControl) this.app.connection.sendLost(side);
    this.forget();
    this.set("off", note);
  }

  private forget(): void {
    this.goal = null;
    this.pose = null;
    this.closed = null;
  }

  /** Poses another of the scene's hands; the present one stays as it is. */
  choose(hand: number): void {
    if (hand === this.hand) return;
    const before = this.model?.side ?? null;
    if (this.on && before !== null) this.app.connection.sendLost(before);
    this.hand = hand;
    this.forget();
    this.changed();
  }

  moveWrist(by: Vector3): void {
    this.aim((goal) => void goal.position.add(by));
  }

  /** Turns the wrist in the world frame, in place. */
  turnWrist(by: Quaternion): void {
    this.aim((goal) => void goal.rotation.premultiply(by));
  }

  shape(name: Preset): void {
    this.aim((goal, hand) => {
      const angles = presetOf(name, hand);
      this.closed = thumbLast(name) ? clampAngles(angles, hand) : null;
      goal.angles = this.closed === null ? angles : thumbAside(angles);
    });
  }

  /** The fingers keep what sets them apart from the slider's shape, until an end is reached. */
  setGrasp(amount: number): void {
    this.closed = null;
    this.aim((goal) => {
      const from = grasp(graspOf(goal.angles));
      goal.angles = moved(goal.angles, 0, from, grasp(amount), amount);
    });
  }

  setCurl(digit: number, amount: number): void {
    if (digit === 0) this.closed = null;
    this.aim((goal) => {
      const from = curl(digit, curlOf(digit, goal.angles));
      goal.angles = moved(goal.angles, 4 * digit, from, curl(digit, amount), amount);
    });
  }

  setSpread(share: number): void {
    this.aim((goal) => setSpread(goal.angles, share));
  }

  /** Where the sliders stand for the present goal, or for the hand as it is. */
  sliders(): Sliders {
    const { snapshot } = this.app.feed;
    const hand = this.model;
    const angles =
      this.goal?.angles ??
      (hand !== null && snapshot !== null ? presentPose(hand, snapshot).angles : new Float64Array(20));
    return {
      grasp: graspOf(angles),
      curls: Array.from({ length: DIGIT_COUNT }, (_, digit) => curlOf(digit, angles)),
      spread: spreadOf(angles),
    };
  }

  private aim(change: (goal: HandPose, hand: HandModel) => void): void {
    const hand = this.model;
    if (!this.on || hand === null || !this.acquire(hand)) return;
    const { goal, pose } = this;
    if (goal === null || pose === null) return;
    change(goal, hand);
    clampPose(goal, hand, pose);
    this.changed();
  }

  /** Starts from where the hand is; false while that is not known. */
  private acquire(hand: HandModel): boolean {
    if (this.pose !== null) return true;
    const { snapshot } = this.app.feed;
    if (snapshot === null || this.app.connection.snapshot === null) return false;
    this.pose = presentPose(hand, snapshot);
    this.goal = copyPose(this.pose);
    return true;
  }

  private tick(): void {
    const now = performance.now();
    const dt = Math.min(DT_MOST, (now - this.before) / 1000);
    this.before = now;
    const hand = this.model;
    const { connection } = this.app;
    if (hand === null || hand.side === null || !connection.inControl || !this.acquire(hand)) return;
    this.onTick?.(dt);
    const { goal, pose } = this;
    if (goal === null || pose === null) return;
    if (this.closed !== null && fingersAre(pose.angles, goal.angles)) {
      goal.angles.set(this.closed.subarray(0, 4));
      this.closed = null;
    }
    follow(pose, goal, dt);
    connection.sendAngles(hand.side, wristNumbers(pose), pose.angles);
  }
}

/** `angles` with the change from one shape to another added from index `at`; an end of the slider
 * is the shape itself. */
function moved(angles: Angles, at: number, from: Angles, to: Angles, amount: number): Angles {
  const out = angles.slice();
  const exact = amount <= 0 || amount >= 1;
  for (let i = 0; i < to.length; i++) out[at + i] = exact ? to[i] : out[at + i] + to[i] - from[i];
  return out;
}
