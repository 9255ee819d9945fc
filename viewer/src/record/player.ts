// Plays a recording: a place among its snapshots, moved by time, by scrubbing or frame by frame.

import { decode } from "../protocol/decode";
import type { SceneModel, Snapshot } from "../protocol/types";
import { isModel, type Entry } from "./container";

interface Frame {
  readonly time: number;
  readonly message: ArrayBuffer;
  /** Index into models. */
  readonly model: number;
}

export interface Shown {
  readonly model: SceneModel;
  readonly snapshot: Snapshot;
}

export class Player {
  playing = false;
  /** Recorded over real time. */
  speed = 1;
  private readonly frames: Frame[] = [];
  private readonly models: ArrayBuffer[] = [];
  private decoded: { readonly index: number; readonly model: SceneModel } | null = null;
  private place = 0;

  /** `entries` as `read` or `Recorder.entries` give them: at least one model and one snapshot. */
  constructor(entries: readonly Entry[]) {
    for (const { time, message } of entries) {
      if (isModel(message)) this.models.push(message);
      else this.frames.push({ time, message, model: this.models.length - 1 });
    }
    if (this.frames.length === 0 || this.frames[0].model < 0) {
      throw new RangeError("A recording needs a model and a snapshot.");
    }
    this.place = this.first;
  }

  get length(): number {
    return this.frames.length;
  }

  private get first(): number {
    return this.frames[0].time;
  }

  /** s */
  get duration(): number {
    return this.frames[this.frames.length - 1].time - this.first;
  }

  /** Since the first snapshot, s. */
  get time(): number {
    return this.place - this.first;
  }

  set time(value: number) {
    this.place = this.first + Math.min(this.duration, Math.max(0, value));
  }

  /** The snapshot at the present place: the last one not after it. */
  get index(): number {
    let [low, high] = [0, this.frames.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.frames[middle].time <= this.place) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /** So many snapshots on, or back. */
  step(count: number): void {
    this.playing = false;
    const to = Math.min(this.length - 1, Math.max(0, this.index + count));
    this.place = this.frames[to].time;
  }

  /** Lets `dt` seconds pass; stops at the end. */
  advance(dt: number): void {
    if (!this.playing) return;
    this.time += dt * this.speed;
    if (this.time >= this.duration) this.playing = false;
  }

  /** Model and snapshot at the present place. Throws `ProtocolError` for a message that makes no
   * sense. */
  show(now: number): Shown {
    const frame = this.frames[this.index];
    if (this.decoded?.index !== frame.model) {
      const message = decode(this.models[frame.model], null, now);
      if (message.kind !== "model") throw new RangeError("The recording's model is none.");
      this.decoded = { index: frame.model, model: message.model };
    }
    const { model } = this.decoded;
    const message = decode(frame.message, model, now);
    if (message.kind !== "snapshot") {
      throw new RangeError("A snapshot in the recording belongs to another model.");
    }
    return { model, snapshot: message.snapshot };
  }
}
