// Keeps the newest messages within a bound of time and memory. The oldest snapshots go first; the
// models that the remaining ones belong to stay.

import { isModel, type Entry } from "./container";

export interface Bounds {
  /** s */
  readonly seconds: number;
  readonly bytes: number;
}

export const BOUNDS: Bounds = { seconds: 120, bytes: 300e6 };

/** Snapshots of one model. */
interface Run {
  readonly model: Entry;
  readonly snapshots: Entry[];
  /** Snapshots before this index are dropped. */
  first: number;
}

export class Recorder {
  private runs: Run[] = [];
  private held = 0;
  private droppedCount = 0;
  private start = 0;
  private newest = 0;

  constructor(readonly bounds: Bounds = BOUNDS) {}

  get bytes(): number {
    return this.held;
  }

  /** Snapshots dropped to stay within the bounds. */
  get dropped(): number {
    return this.droppedCount;
  }

  get snapshots(): number {
    return this.runs.reduce((sum, run) => sum + run.snapshots.length - run.first, 0);
  }

  /** From the oldest snapshot held to the newest, s. */
  get seconds(): number {
    const run = this.runs.find((r) => r.first < r.snapshots.length);
    return run === undefined ? 0 : this.newest - run.snapshots[run.first].time;
  }

  /** Starts anew at the clock time `now`, s, with the model in force. */
  begin(model: ArrayBuffer, now: number): void {
    this.runs = [];
    this.held = 0;
    this.droppedCount = 0;
    this.start = now;
    this.newest = 0;
    this.add(model, now);
  }

  add(message: ArrayBuffer, now: number): void {
    this.newest = Math.max(this.newest, now - this.start);
    const entry = { time: this.newest, message };
    this.held += message.byteLength;
    if (isModel(message)) this.runs.push({ model: entry, snapshots: [], first: 0 });
    else this.runs.at(-1)?.snapshots.push(entry);
    this.trim();
  }

  /** What is held, times counted from the first. */
  entries(): Entry[] {
    const runs = this.runs.filter((run) => run.first < run.snapshots.length);
    const all = runs.flatMap((run) => {
      const kept = run.snapshots.slice(run.first);
      // A model whose first snapshots are gone comes with the first that is left.
      return [{ ...run.model, time: run.first > 0 ? kept[0].time : run.model.time }, ...kept];
    });
    const start = all.length === 0 ? 0 : all[0].time;
    return all.map(({ time, message }) => ({ time: time - start, message }));
  }

  private trim(): void {
    while (this.seconds > this.bounds.seconds || this.held > this.bounds.bytes) {
      const run = this.runs[0];
      if (run === undefined || (this.runs.length === 1 && run.first >= run.snapshots.length - 1)) return;
      if (run.first >= run.snapshots.length) {
        this.runs.shift();
        this.held -= run.model.message.byteLength;
        continue;
      }
      this.held -= run.snapshots[run.first].message.byteLength;
      run.first += 1;
      this.droppedCount += 1;
      if (run.first > 1024) {
        run.snapshots.splice(0, run.first);
        run.first = 0;
        // The model then comes first, at the time of what is left.
        this.runs[0] = { ...run, model: { ...run.model, time: run.snapshots[0]?.time ?? this.newest } };
      }
    }
  }
}
