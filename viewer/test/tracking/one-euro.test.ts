// The filter against its own definition: a first-order low pass at rest, quick when fast.

import { describe, expect, it } from "vitest";
import { OneEuro } from "../../src/tracking/one-euro";

describe("1-euro filter", () => {
  it("lets the first sample through and keeps a constant", () => {
    const filter = new OneEuro(2, { cutoff: 1, beta: 0, speedCutoff: 1 });
    for (let i = 0; i < 5; i++) {
      const numbers = Float64Array.of(3, -2);
      filter.filter(numbers, i / 30);
      expect([...numbers]).toEqual([3, -2]);
    }
  });

  it("reaches 1 - 1/e of a step after the time constant 1 / (2 pi cutoff)", () => {
    const cutoff = 0.5;
    const filter = new OneEuro(1, { cutoff, beta: 0, speedCutoff: 1 });
    filter.filter(Float64Array.of(0), 0);
    const dt = 1e-3;
    const numbers = Float64Array.of(1);
    for (let t = dt; t <= 1 / (2 * Math.PI * cutoff); t += dt) {
      numbers[0] = 1;
      filter.filter(numbers, t);
    }
    expect(Math.abs(numbers[0] - (1 - Math.exp(-1)))).toBeLessThan(0.005);
  });

  it("lags less the faster it goes", () => {
    const lag = (beta: number) => {
      const filter = new OneEuro(1, { cutoff: 1, beta, speedCutoff: 1 });
      const numbers = Float64Array.of(0);
      for (let i = 0; i <= 60; i++) {
        numbers[0] = i / 30;
        filter.filter(numbers, i / 30);
      }
      return 2 - numbers[0];
    };
    // A ramp of 1/s lags by the time constant without beta; the sampled filter by one sample less.
    expect(Math.abs(lag(0) - 1 / (2 * Math.PI))).toBeLessThan(0.04);
    expect(lag(5)).toBeLessThan(lag(0) / 3);
  });

  it("starts anew after a reset", () => {
    const filter = new OneEuro(1, { cutoff: 1, beta: 0, speedCutoff: 1 });
    filter.filter(Float64Array.of(0), 0);
    filter.reset();
    const numbers = Float64Array.of(9);
    filter.filter(numbers, 1);
    expect(numbers[0]).toBe(9);
  });
});
