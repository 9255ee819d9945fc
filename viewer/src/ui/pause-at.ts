// Brings the simulation to a wanted moment and stops it there, with commands only: it runs until
// shortly before, pauses, then goes step by step, so that the last step is the wanted one whatever
// the line's delay.

import type { Command } from "../protocol/types";

/** Run freely until this long before the moment, s of real time at the speed reached. */
const APPROACH = 0.15;
/** A command not seen to act within this time is sent again, ms. */
const PATIENCE = 500;

export interface Moment {
  /** Simulated time, s. */
  readonly time: number;
  readonly paused: boolean;
  /** Time step, s. */
  readonly step: number;
  /** `performance.now()`, ms. */
  readonly now: number;
}

export class PauseAt {
  done = false;
  private waiting: { readonly time: number; readonly paused: boolean; readonly since: number } | null = null;

  constructor(readonly target: number) {}

  /** What to send now, seeing this snapshot; null to wait. */
  next(moment: Moment): Command | null {
    if (this.done) return null;
    const half = 0.5 * moment.step;
    const left = this.target - moment.time;
    if (moment.paused && Math.abs(left) <= half) {
      this.done = true;
      return null;
    }
    if (this.unanswered(moment)) return null;
    const command = this.choose(left, half, moment);
    this.waiting = command === null ? null : { ...moment, since: moment.now };
    return command;
  }

  private choose(left: number, half: number, moment: Moment): Command | null {
    // Too far already: from the start again.
    if (left < -half) return { type: "reset" };
    if (moment.paused) return left > APPROACH ? { type: "run", paused: false } : { type: "step" };
    return left <= APPROACH ? { type: "run", paused: true } : null;
  }

  /** True while the last command has neither shown an effect nor been given up. */
  private unanswered(moment: Moment): boolean {
    const last = this.waiting;
    if (last === null) return false;
    const acted = last.paused !== moment.paused || (last.paused && last.time !== moment.time);
    const backAtStart = moment.time < last.time;
    return !acted && !backAtStart && moment.now - last.since < PATIENCE;
  }
}
