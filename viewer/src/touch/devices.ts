// What the page knows of the devices that feel the scene, and what it does about it: it keeps
// forces alive while it is there, if it armed them, and gets a stop through.

import type { Command, Touch } from "../protocol/types";

/** Reports come four times a second; with none for so long, nothing is known, ms. */
export const REPORT_OVERDUE = 1500;
/** A stop that has not shown by then is sent again, ms. */
const STOP_AGAIN = 500;
/** An arming that has not shown by then was refused, ms. */
const ARM_OVERDUE = 1500;
/** Deadlines are counted over so long, ms. */
const WINDOW = 10_000;

/** How much is at stake: no force can come, it can, or nobody knows. */
export type Level = "safe" | "armed" | "stopped" | "unknown";

export interface Deadlines {
  readonly missed: number;
  readonly of: number;
}

/** Where commands go, and who this page is. */
export interface Line {
  send(command: Command): boolean;
  /** This page's number. */
  me(): number | null;
}

export class Devices {
  /** The newest report. */
  touch: Touch | null = null;
  /** A stop was asked for here and has not been seen to act. */
  stopping = false;
  private armedAt = -Infinity;
  private connected = false;
  private reportedAt = -Infinity;
  private stoppedAt = -Infinity;
  private readonly past: { readonly at: number; readonly ticks: number; readonly missed: number }[] = [];

  constructor(private readonly line: Line) {}

  /** The line is there, be it for the first time or again. */
  opened(now: number): void {
    this.connected = true;
    this.reportedAt = now;
    // Another run of the program counts anew.
    this.past.length = 0;
    if (this.stopping) this.sendStop(now);
  }

  closed(): void {
    this.connected = false;
  }

  reported(touch: Touch, now: number): void {
    this.touch = touch;
    this.reportedAt = now;
    this.count(touch, now);
    if (isArmed(touch)) this.armedAt = -Infinity;
    if (!isArmed(touch)) this.stopping = false;
    else if (this.stopping && now - this.stoppedAt > STOP_AGAIN) this.sendStop(now);
    // Says that somebody could still press Stop here. Not while a stop is under way.
    if (this.holds && !this.stopping) this.line.send({ type: "hold" });
  }

  /** Zero at once; a stop for which there is no line goes out as soon as there is one. */
  stop(now: number): void {
    if (this.touch === null) return;
    this.stopping = true;
    this.armedAt = -Infinity;
    this.sendStop(now);
  }

  /** Lets forces through; `keep`: also when this page has gone. */
  arm(keep: boolean, now: number): void {
    this.stopping = false;
    if (this.line.send(keep ? { type: "arm", keep } : { type: "arm" })) this.armedAt = now;
  }

  /** It was asked for here and has not been seen to act. */
  isArming(now: number): boolean {
    return now - this.armedAt < ARM_OVERDUE;
  }

  /** Forces last while this page is there. */
  get holds(): boolean {
    const by = this.touch?.armed_by ?? null;
    return by !== null && by === this.line.me();
  }

  level(now: number): Level {
    const { touch } = this;
    if (touch === null) return "safe";
    if (!this.isKnown(now)) return "unknown";
    if (isArmed(touch)) return "armed";
    return touch.state === "dry-run" ? "safe" : "stopped";
  }

  isKnown(now: number): boolean {
    return this.connected && now - this.reportedAt <= REPORT_OVERDUE;
  }

  /** In a word or two. */
  headline(now: number): string {
    const level = this.level(now);
    if (level === "unknown") return "Not known";
    if (level === "armed") return this.stopping ? "Stopping…" : "ARMED";
    if (this.isArming(now)) return "Arming…";
    if (level === "safe") return "Dry run";
    return this.touch?.state === "failed" ? "Failed" : "Stopped";
  }

  /** Why it is so, and what that means. */
  reason(now: number): string {
    const { touch } = this;
    if (touch === null) return "";
    const why = touch.reason === null ? "" : sentence(touch.reason);
    if (!this.isKnown(now)) return this.unknown();
    switch (touch.state) {
      case "dry-run":
        return "No force goes out. The hand can be moved.";
      case "waiting":
        return why === ""
          ? "No force yet: it waits until the hand is free for a moment."
          : `No force for now. ${why}`;
      case "ramping":
        return "Force grows.";
      case "live":
        return "Full force.";
      case "tripped":
        return `No force until armed again. ${why}`;
      case "failed":
        return "The haptic loop has failed. Start the program again.";
    }
  }

  /** What keeps forces alive, while armed. */
  keeper(now: number): string {
    if (this.level(now) !== "armed") return "";
    const by = this.touch?.armed_by ?? null;
    if (by === null) return "Armed until somebody stops it, whether or not a page is open.";
    return this.holds
      ? "Forces end when this page is closed or loses its connection."
      : `Viewer ${by} armed; forces end when that page goes.`;
  }

  /** How regular the loop was of late; null before two reports. */
  deadlines(): Deadlines | null {
    const [first, last] = [this.past[0], this.past[this.past.length - 1]];
    if (first === undefined || last === undefined || last.at <= first.at) return null;
    const missed = last.missed - first.missed;
    const of = last.ticks - first.ticks + missed;
    return { missed, of };
  }

  private unknown(): string {
    const what = this.connected
      ? "The program has not told of the devices for a while."
      : "The connection is lost.";
    if (this.touch === null || !isArmed(this.touch)) return what;
    const then = this.holds
      ? "This page armed them, so forces end by themselves within three seconds."
      : "Forces may still be on: take the hand out, or end the program.";
    const asked = this.stopping ? " Stop goes out as soon as the connection is back." : "";
    return `${what} ${then}${asked}`;
  }

  private sendStop(now: number): void {
    if (this.line.send({ type: "stop" })) this.stoppedAt = now;
  }

  private count({ ticks, missed }: Touch, now: number): void {
    const last = this.past[this.past.length - 1];
    if (last !== undefined && (ticks < last.ticks || missed < last.missed)) this.past.length = 0;
    this.past.push({ at: now, ticks, missed });
    while (this.past.length > 2 && now - this.past[0].at > WINDOW) this.past.shift();
  }
}

/** Forces go out, or may at any moment. */
export function isArmed({ state }: Touch): boolean {
  return state === "waiting" || state === "ramping" || state === "live";
}

function sentence(text: string): string {
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}.`;
}
