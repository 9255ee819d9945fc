// The numbers of a whole hand, from those of its digits.

import { describe, expect, it } from "vitest";
import { wholeHand } from "../../src/ui/quantities";

describe("a whole hand", () => {
  it("adds up forces and areas, and spreads what skin bears over all of it", () => {
    const fingers = new Float32Array(24);
    // The thumb: 20 N, of which bones bear 17; the index finger: skin alone.
    fingers.set([20, 1, 3e-5, 3 / 3e-5], 4);
    fingers.set([2, 0.5, 1e-5, 2 / 1e-5], 8);
    const [normal, shear, area, pressure] = wholeHand(fingers);
    expect([normal, shear]).toEqual([22, 1.5]);
    expect(area).toBeCloseTo(4e-5, 9);
    expect(pressure).toBeCloseTo(5 / 4e-5, 0);
    expect(wholeHand(new Float32Array(24))).toEqual([0, 0, 0, 0]);
  });
});
