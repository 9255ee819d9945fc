import { describe, expect, it } from "vitest";
import { SLIDER_STEPS, fromPosition, sameValue, toPosition, type Range } from "../../src/ui/slider-map";

const ranges: Range[] = [
  { min: 0, max: 2, scale: "linear" },
  { min: -10, max: 5, scale: "linear" },
  { min: 1e3, max: 1e9, scale: "log" },
  { min: 1e-6, max: 1e-2, scale: "log" },
];

describe("sliders", () => {
  it("reach both ends exactly", () => {
    for (const range of ranges) {
      expect(fromPosition(0, range)).toBe(range.min);
      expect(fromPosition(SLIDER_STEPS, range)).toBe(range.max);
      expect(toPosition(range.min, range)).toBe(0);
      expect(toPosition(range.max, range)).toBeCloseTo(SLIDER_STEPS, 9);
    }
  });

  it("come back to where they were, within one step", () => {
    for (const range of ranges) {
      for (let p = 0; p <= SLIDER_STEPS; p++) {
        expect(Math.abs(toPosition(fromPosition(p, range), range) - p)).toBeLessThan(1);
      }
    }
  });

  it("put the geometric mean in the middle of a log scale", () => {
    expect(fromPosition(500, { min: 1e3, max: 1e9, scale: "log" })).toBe(1e6);
  });

  it("stay in range and take a log scale from zero as linear", () => {
    expect(toPosition(99, ranges[0])).toBe(SLIDER_STEPS);
    expect(fromPosition(500, { min: 0, max: 8, scale: "log" })).toBe(4);
    expect(toPosition(3, { min: 3, max: 3, scale: "linear" })).toBe(0);
  });
});

describe("the same value", () => {
  it("is one that differs by rounding only", () => {
    // Flesh incompressibility, there and back.
    expect(sameValue(0.4300000000000005, 0.43000000000000044)).toBe(true);
    expect(sameValue(-2e9, -2e9 * (1 + 1e-12))).toBe(true);
    expect(sameValue(0, 0)).toBe(true);
  });

  it("is not one that a visitor can set apart", () => {
    // One step of a slider over a decade is a factor of 1.0023; typed values have four digits.
    expect(sameValue(0.43, 0.4301)).toBe(false);
    expect(sameValue(0, 1e-12)).toBe(false);
    expect(sameValue("monolithic", "two-step")).toBe(false);
  });
});
