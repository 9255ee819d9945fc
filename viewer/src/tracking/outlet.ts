// The way of tracked hands to the server: poses of the hands the scene has, while this page holds
// control. What the server would refuse is not sent.

import type { Connection } from "../net/connection";
import type { HandsChoice, Side } from "../protocol/types";
import type { HandJoints } from "./joints";

export const SIDES: readonly Side[] = ["left", "right"];

export class PoseOutlet {
  private readonly moving = new Set<Side>();

  constructor(private readonly connection: Connection) {}

  /** Whether the scene has this hand and this page may move it. */
  accepts(side: Side): boolean {
    const { inControl, model } = this.connection;
    return inControl && model !== null && model.hands.some((hand) => hand.side === side);
  }

  /** Sides of the hands that move. */
  led(): readonly Side[] {
    return SIDES.filter((side) => this.moving.has(side));
  }

  joints(side: Side, joints: HandJoints): boolean {
    if (!this.accepts(side)) return false;
    this.moving.add(side);
    return this.connection.sendJoints(side, joints) > 0;
  }

  angles(side: Side, wrist: ArrayLike<number>, angles: ArrayLike<number>): boolean {
    if (!this.accepts(side)) return false;
    this.moving.add(side);
    return this.connection.sendAngles(side, wrist, angles) > 0;
  }

  lost(side: Side): void {
    if (!this.moving.delete(side)) return;
    if (this.accepts(side)) this.connection.sendLost(side);
  }

  lostAll(): void {
    for (const side of SIDES) this.lost(side);
  }
}

/** Hands wanted, and how long they are, m; null: as the model is. */
export type Lengths = Partial<Record<Side, number | null>>;

/** Asks for the hands somebody brings along, scaled to them, and puts back what was before. */
export class HandsRequest {
  private before: HandsChoice | null = null;
  private asked = "";

  constructor(private readonly connection: Connection) {}

  /** Asks once for the same thing; true if it was asked now. Rebuilds the scene. */
  ask(lengths: Lengths): boolean {
    const { inControl, status } = this.connection;
    if (!inControl || status === null) return false;
    const sides = SIDES.filter((side) => lengths[side] !== undefined);
    if (sides.length === 0) return false;
    const which: HandsChoice = sides.length === 2 ? "both" : sides[0];
    const { left = null, right = null } = lengths;
    const asked = JSON.stringify([which, left, right]);
    if (asked === this.asked) return false;
    if (!this.connection.send({ type: "hands", which, lengths: { left, right } })) return false;
    this.before ??= status.hands;
    this.asked = asked;
    return true;
  }

  /** After a reconnection the server may be a new one: what was asked for is asked for again. */
  forget(): void {
    this.asked = "";
  }

  /** Back to the hands of before, at the size of the model. */
  restore(): void {
    const which = this.before;
    this.before = null;
    this.asked = "";
    if (which === null || !this.connection.inControl) return;
    this.connection.send({ type: "hands", which, lengths: { left: null, right: null } });
  }
}
