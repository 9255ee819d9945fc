// How long frames take, without making garbage.

const FRAMES = 120;

export class FrameClock {
  frames = 0;
  private readonly costs = new Float64Array(FRAMES);
  private readonly times = new Float64Array(FRAMES);

  add(now: number, cost: number): void {
    this.costs[this.frames % FRAMES] = cost;
    this.times[this.frames % FRAMES] = now;
    this.frames += 1;
  }

  /** Median processor time of a frame over the last 120, ms. */
  get cost(): number {
    const count = Math.min(this.frames, FRAMES);
    if (count === 0) return 0;
    return this.costs.slice(0, count).sort()[count >> 1];
  }

  /** Frames per second over the last second. */
  fps(now: number): number {
    const count = Math.min(this.frames, FRAMES);
    let recent = 0;
    let oldest = now;
    for (let i = 0; i < count; i++) {
      if (now - this.times[i] > 1000) continue;
      recent += 1;
      oldest = Math.min(oldest, this.times[i]);
    }
    return recent < 2 ? recent : (1000 * (recent - 1)) / Math.max(1, now - oldest);
  }
}
