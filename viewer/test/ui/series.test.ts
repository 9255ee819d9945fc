import { describe, expect, it } from "vitest";
import { RollingSeries } from "../../src/ui/series";

describe("rolling series", () => {
  it("keeps the last span of time, oldest first", () => {
    const series = new RollingSeries(2, 100, 1);
    for (let i = 0; i <= 30; i++) series.push(i / 10, [i, -i]);
    const [times, second] = series.read([1]);
    expect(times.length).toBe(11);
    expect(times[0]).toBeCloseTo(2, 12);
    expect([second[0], second[10]]).toEqual([-20, -30]);
  });

  it("never holds more than its capacity", () => {
    const series = new RollingSeries(1, 8, 1e9);
    for (let i = 0; i < 1000; i++) series.push(i, [i]);
    const [times, values] = series.read([0]);
    expect(Array.from(times)).toEqual([992, 993, 994, 995, 996, 997, 998, 999]);
    expect(Array.from(values)).toEqual(Array.from(times));
  });

  it("starts anew when time goes back, and replaces a sample of the same time", () => {
    const series = new RollingSeries(1, 8, 10);
    series.push(5, [1]);
    series.push(6, [2]);
    series.push(6, [3]);
    expect(Array.from(series.read([0])[1])).toEqual([1, 3]);
    series.push(0, [4]);
    expect(series.length).toBe(1);
    series.push(NaN, [5]);
    expect(series.last).toBe(0);
  });
});
