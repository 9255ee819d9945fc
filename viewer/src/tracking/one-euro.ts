// The 1-euro filter (Casiez, Roussel and Vogel, CHI 2012): a low pass whose cut-off rises with
// speed, so that a still hand does not tremble and a fast one does not lag.

export interface OneEuroOptions {
  /** Cut-off at rest, Hz: lower trembles less and lags more. */
  readonly cutoff: number;
  /** Rise of the cut-off with speed, Hz per unit/s. */
  readonly beta: number;
  /** Cut-off for the speed itself, Hz. */
  readonly speedCutoff: number;
}

const share = (cutoff: number, dt: number) => 1 / (1 + 1 / (2 * Math.PI * cutoff * dt));

/** Filters several numbers at once, in place. */
export class OneEuro {
  private values: Float64Array | null = null;
  private readonly speeds: Float64Array;
  private time = 0;

  constructor(
    readonly count: number,
    readonly options: OneEuroOptions,
  ) {
    this.speeds = new Float64Array(count);
  }

  reset(): void {
    this.values = null;
    this.speeds.fill(0);
  }

  /** `time` in seconds, rising. */
  filter(numbers: Float32Array | Float64Array, time: number): void {
    if (this.values === null) {
      this.values = Float64Array.from(numbers.subarray(0, this.count));
      this.time = time;
      return;
    }
    const dt = Math.max(1e-3, time - this.time);
    this.time = time;
    const speedShare = share(this.options.speedCutoff, dt);
    for (let i = 0; i < this.count; i++) {
      const speed = (numbers[i] - this.values[i]) / dt;
      this.speeds[i] += speedShare * (speed - this.speeds[i]);
      const cutoff = this.options.cutoff + this.options.beta * Math.abs(this.speeds[i]);
      this.values[i] += share(cutoff, dt) * (numbers[i] - this.values[i]);
      numbers[i] = this.values[i];
    }
  }
}
