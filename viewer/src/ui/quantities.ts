// What is plotted: per hand and digit force, area and pressure, and what the step costs.

import { DIGITS, PER_DIGIT, PER_HAND, type Snapshot } from "../protocol/types";

/** Colours that differ for colour-blind eyes too (after Okabe and Ito), on light and dark. */
export const DIGIT_COLOURS = ["#8d97a5", "#e0651a", "#d99a00", "#00a37a", "#3d9fe0", "#c56fa3"] as const;
export const DIGIT_LABELS = DIGITS.map((digit) => digit[0].toUpperCase() + digit.slice(1));

export const HANDS_MOST = 2;
const STEP = HANDS_MOST * PER_HAND;
export const COLUMNS = STEP + 5;

export interface Curve {
  readonly label: string;
  readonly colour: string;
  readonly column: number;
  readonly dashed?: boolean;
}

export interface Quantity {
  readonly id: string;
  readonly label: string;
  readonly unit: string;
  /** Shown value over SI value. */
  readonly factor: number;
  /** Top of the scale at least, in shown units. */
  readonly least: number;
  curves(hand: number): readonly Curve[];
}

function perDigit(
  id: string,
  label: string,
  unit: string,
  factor: number,
  least: number,
  k: number,
): Quantity {
  return {
    id,
    label,
    unit,
    factor,
    least,
    curves: (hand) =>
      DIGITS.map((_, d) => ({
        label: DIGIT_LABELS[d],
        colour: DIGIT_COLOURS[d],
        column: PER_HAND * hand + PER_DIGIT * d + k,
      })),
  };
}

export const QUANTITIES: readonly Quantity[] = [
  perDigit("normal", "Normal force", "N", 1, 0.5, 0),
  perDigit("shear", "Shear force", "N", 1, 0.5, 1),
  perDigit("area", "Contact area", "mm²", 1e6, 50, 2),
  perDigit("pressure", "Mean pressure", "kPa", 1e-3, 5, 3),
  {
    id: "cost",
    label: "Step time",
    unit: "ms",
    factor: 1,
    least: 1,
    curves: () => [
      { label: "Cost of a step", colour: DIGIT_COLOURS[4], column: STEP },
      { label: "Budget", colour: DIGIT_COLOURS[1], column: STEP + 1, dashed: true },
    ],
  },
  {
    id: "energy",
    label: "Energy",
    unit: "mJ",
    factor: 1e3,
    least: 1,
    curves: () => [
      { label: "Total", colour: DIGIT_COLOURS[0], column: STEP + 2, dashed: true },
      { label: "Kinetic", colour: DIGIT_COLOURS[4], column: STEP + 3 },
      { label: "Elastic", colour: DIGIT_COLOURS[1], column: STEP + 4 },
    ],
  },
];

/** Sums of a hand's digits, and the mean pressure on all skin that touches. */
export function wholeHand(fingers: Float32Array): number[] {
  const sums = [0, 0, 0];
  let onSkin = 0;
  for (let at = 0; at < PER_HAND; at += PER_DIGIT) {
    for (let k = 0; k < 3; k++) sums[k] += fingers[at + k];
    onSkin += fingers[at + 2] * fingers[at + 3];
  }
  return [...sums, sums[2] > 0 ? onSkin / sums[2] : 0];
}

/** One sample of all columns; hands that are not there are NaN. */
export function sample(snapshot: Snapshot, out: Float32Array): void {
  out.fill(NaN, 0, STEP);
  const { fingers, energy } = snapshot;
  out.set(fingers.subarray(0, STEP));
  out.set([snapshot.stepCost, snapshot.stepBudget, energy.total, energy.kinetic, energy.elastic], STEP);
}
