// Small running measurements of the line: clock offset, pose latency, bytes per second.

/** Offset of the server's clock, from the quickest of the recent pings. */
export class Clock {
  /** Server's clock minus `performance.now()`, s; null before the first answer. */
  offset: number | null = null;
  /** Round trip of the quickest recent ping, s. */
  roundTrip: number | null = null;
  private readonly recent: { trip: number; offset: number }[] = [];

  reset(): void {
    this.recent.length = 0;
    this.offset = null;
    this.roundTrip = null;
  }

  /** Sent at `t`, stamped `server` by the other side, back at `now`; all s. */
  pong(t: number, server: number, now: number): void {
    const trip = now - t;
    if (!(trip >= 0) || !Number.isFinite(server)) return;
    this.recent.push({ trip, offset: server - (t + now) / 2 });
    if (this.recent.length > 8) this.recent.shift();
    const best = this.recent.reduce((a, b) => (b.trip < a.trip ? b : a));
    this.offset = best.offset;
    this.roundTrip = best.trip;
  }
}

/** Time from sending a pose to the first snapshot in which it, or a later one, acted. */
export class Latency {
  private readonly times = new Float64Array(64);
  private readonly numbers = new Uint32Array(64);
  private readonly recent: number[] = [];
  private last = 0;

  reset(): void {
    this.numbers.fill(0);
    this.recent.length = 0;
    this.last = 0;
  }

  sent(number: number, now: number): void {
    this.times[number % 64] = now;
    this.numbers[number % 64] = number;
  }

  acted(number: number, now: number): void {
    if (number === this.last || number === 0 || this.numbers[number % 64] !== number) return;
    this.last = number;
    this.recent.push(now - this.times[number % 64]);
    if (this.recent.length > 120) this.recent.shift();
  }

  /** Median of the last 120, ms; null before the first. */
  get median(): number | null {
    if (this.recent.length === 0) return null;
    const sorted = [...this.recent].sort((a, b) => a - b);
    return sorted[sorted.length >> 1];
  }
}

/** Bytes per second over the last second or two. */
export class Throughput {
  bytesPerSecond = 0;
  total = 0;
  private since = 0;
  private bytes = 0;

  add(bytes: number, now: number): void {
    this.total += bytes;
    this.bytes += bytes;
    if (this.since === 0) this.since = now;
    const span = now - this.since;
    if (span >= 1000) {
      this.bytesPerSecond = (1000 * this.bytes) / span;
      this.bytes = 0;
      this.since = now;
    }
  }
}
