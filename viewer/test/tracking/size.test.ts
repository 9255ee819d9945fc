// The wearer's size from lengths and radii.

import { describe, expect, it } from "vitest";
import { newHandJoints } from "../../src/tracking/joints";
import { packJoints } from "../../src/tracking/pack";
import { MODEL_LENGTH, SizeMedian, sizeOf } from "../../src/tracking/size";
import { STORED_POSES, storedHand, straightHand } from "./hands";

/** The model's chains, from the bones of the mesh: sums of its bones to the skin, m. */
const CHAINS = [
  0.0819 + 0.0338 + 0.0242,
  0.0919 + 0.0453 + 0.0243 + 0.0221,
  0.0917 + 0.0469 + 0.0275 + 0.0239,
  0.0867 + 0.0429 + 0.0266 + 0.0226,
  0.0829 + 0.0346 + 0.0203 + 0.0208,
];
/** Mean of the model's half widths, m. */
const WIDTH = 0.0075;

const scaled = (scale: number, radius: number) =>
  sizeOf(straightHand(CHAINS.map((chain) => chain * scale), radius));

describe("size", () => {
  it("is the model's for the model's lengths and widths", () => {
    expect(scaled(1, WIDTH)?.length).toBeCloseTo(MODEL_LENGTH, 3);
  });

  it("scales with the hand", () => {
    const one = scaled(1, WIDTH)?.length ?? NaN;
    expect(scaled(0.8, 0.8 * WIDTH)?.length).toBeCloseTo(0.8 * one, 6);
    expect(scaled(1.15, 1.15 * WIDTH)?.length).toBeCloseTo(1.15 * one, 6);
  });

  it("lets thick fingers count for a tenth and reports them", () => {
    const one = scaled(1, WIDTH);
    const thick = scaled(1, 1.2 * WIDTH);
    // Fourteen radii good to 10 % against five lengths good to 2 %.
    const share = (14 / 0.1 ** 2) / (14 / 0.1 ** 2 + 5 / 0.02 ** 2);
    const mean = (one?.thickness ?? NaN) * 0.2 * share;
    expect((thick?.length ?? NaN) / MODEL_LENGTH - (one?.length ?? NaN) / MODEL_LENGTH).toBeCloseTo(mean, 4);
    expect((thick?.thickness ?? NaN) / (one?.thickness ?? NaN)).toBeCloseTo(1.2, 5);
  });

  it("does not believe radii far off, nor hands of no hand's size", () => {
    const plain = scaled(1, 0);
    expect(plain?.usedRadii).toBe(false);
    expect(plain?.length).toBeCloseTo(MODEL_LENGTH, 3);
    expect(scaled(3, WIDTH)).toBeNull();
    expect(sizeOf(newHandJoints())).toBeNull();
  });

  it("does not depend on the pose of the hand", () => {
    const sizes = STORED_POSES.map((pose) => {
      const { matrices, radii } = storedHand("left", pose);
      const hand = newHandJoints();
      packJoints(matrices, radii, hand);
      return sizeOf(hand)?.length ?? NaN;
    });
    // IWER's hand is an adult's, some 0.19 m; its three poses were measured, not computed.
    for (const size of sizes) expect(Math.abs(size / sizes[0] - 1)).toBeLessThan(0.005);
    expect(Math.abs(sizes[0] - 0.19)).toBeLessThan(0.005);
  });

  it("waits for a second of frames and takes the median", () => {
    const median = new SizeMedian();
    for (let i = 0; i < 30; i++) {
      const hand = straightHand(CHAINS.map((chain) => chain * (i % 5 === 0 ? 1.3 : 1)), WIDTH);
      median.add(hand, i * 0.033);
      expect(median.get()).toBeNull();
    }
    for (let i = 0; i < 10; i++) median.add(straightHand(CHAINS, WIDTH), 1 + 0.03 * i);
    expect(median.get()?.length).toBeCloseTo(scaled(1, WIDTH)?.length ?? NaN, 6);
  });
});
