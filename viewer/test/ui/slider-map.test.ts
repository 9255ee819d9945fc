import { describe, expect, it } from "vitest";
import { SLIDER_STEPS, fromPosition, toPosition, type Range } from "../../src/ui/slider-map";

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
