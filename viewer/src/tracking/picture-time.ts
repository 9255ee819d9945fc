// How long tracking takes a picture, and when that is too long to lead a hand by sight.

import { fixed } from "../ui/format";

/** Slower than this the hand lags visibly and is lost between pictures, s (`LOST_S` of the webcam). */
const SLOW_S = 0.25;
/** Pictures whose median time counts. */
const RECENT = 5;

export class PictureTime {
  private readonly recent: number[] = [];

  add(seconds: number): void {
    this.recent.push(seconds);
    if (this.recent.length > RECENT) this.recent.shift();
  }

  reset(): void {
    this.recent.length = 0;
  }

  /** What to say about the median of the last pictures; empty while tracking is quick enough. */
  remark(): string {
    const sorted = [...this.recent].sort((a, b) => a - b);
    const median = sorted[sorted.length >> 1] ?? 0;
    if (median < SLOW_S) return "";
    const time = fixed(median, median < 1 ? 1 : 0);
    return ` Tracking takes ${time} s a picture on this machine: the hand follows late.`;
  }
}
