// The last few seconds of many quantities, in a ring that never grows.

export class RollingSeries {
  private readonly times: Float64Array;
  private readonly values: Float32Array;
  private head = 0;
  private count = 0;

  /** `columns` numbers per sample, `capacity` samples, of the last `span` seconds. */
  constructor(
    readonly columns: number,
    readonly capacity: number,
    readonly span: number,
  ) {
    this.times = new Float64Array(capacity);
    this.values = new Float32Array(capacity * columns);
  }

  get length(): number {
    return this.count;
  }

  /** Time of the newest sample, s; NaN if there is none. */
  get last(): number {
    return this.count === 0 ? NaN : this.times[this.slot(this.count - 1)];
  }

  clear(): void {
    this.count = 0;
  }

  /** Adds a sample. A time before the last one starts anew (a reset, or a scrub backwards); the
   * same time again replaces the sample. */
  push(time: number, sample: ArrayLike<number>): void {
    if (!Number.isFinite(time)) return;
    const last = this.last;
    if (time < last) this.clear();
    if (time !== last) {
      if (this.count === this.capacity) this.dropOldest();
      this.count += 1;
    }
    const slot = this.slot(this.count - 1);
    this.times[slot] = time;
    for (let c = 0; c < this.columns; c++) this.values[slot * this.columns + c] = sample[c] ?? NaN;
    while (this.count > 1 && this.times[this.head] < time - this.span) this.dropOldest();
  }

  /** Times and the named columns, oldest first, as the plot wants them. */
  read(columns: readonly number[]): Float64Array[] {
    const out = [new Float64Array(this.count), ...columns.map(() => new Float64Array(this.count))];
    for (let i = 0; i < this.count; i++) {
      const slot = this.slot(i);
      out[0][i] = this.times[slot];
      columns.forEach((c, k) => {
        out[k + 1][i] = this.values[slot * this.columns + c];
      });
    }
    return out;
  }

  private slot(i: number): number {
    return (this.head + i) % this.capacity;
  }

  private dropOldest(): void {
    this.head = (this.head + 1) % this.capacity;
    this.count -= 1;
  }
}
