// Pixels are given up after slow frames have gone on for a while, step by step, down to a floor.

import { describe, expect, it } from "vitest";
import { PixelBudget } from "../src/scene/quality";

describe("the number of pixels", () => {
  it("stays while frames are quick, and through single slow ones", () => {
    const budget = new PixelBudget(0.5);
    for (let i = 0; i < 600; i++) expect(budget.frame(i % 30 === 0 ? 0.1 : 1 / 60)).toBe(false);
    expect(budget.scale).toBe(1);
  });

  it("falls when frames stay slow, never below the least", () => {
    const budget = new PixelBudget(0.5);
    let changes = 0;
    for (let i = 0; i < 200; i++) if (budget.frame(0.5)) changes += 1;
    // 1, 0.8, 0.64, 0.512, 0.5
    expect([changes, budget.scale]).toEqual([4, 0.5]);
  });

  it("takes no notice of a page that was hidden", () => {
    const budget = new PixelBudget(0.5);
    for (let i = 0; i < 20; i++) budget.frame(30);
    expect(budget.scale).toBe(1);
  });
});
