// What is plotted: per hand and digit force, area and pressure, and what the step costs.

import { DIGITS, type Snapshot } from "../protocol/types";

/** Colours that differ for colour-blind eyes too (after Okabe and Ito), on light and dark. */
export const DIGIT_COLOURS = ["#8d97a5", "#e0651a", "#d99a00", "#00a37a", "#3d9fe0", "#c56fa3"] as const;
export const DIGIT_LABELS = DIGITS.map((digit) => digit[0].toUpperCase() + digit.slice(1));

export const HANDS_MOST = 2;
/** Numbers of a hand in a snapshot, and in a sample: normal, shear, area, pressure of each digit. */
const SENT = 18;
const PER_HAND = 24;
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
        column: PER_HAND * hand + 4 * d + k,
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

/** Normal force over contact area, Pa; 0 where nothing is touched. */
export function meanPressure(normal: number, area: number): number {
  return area > 0 ? normal / area : 0;
}

/** One sample of all columns; hands that are not there are NaN. */
export function sample(snapshot: Snapshot, out: Float32Array): void {
  out.fill(NaN, 0, STEP);
  const { fingers, energy } = snapshot;
  const digits = Math.min(fingers.length, HANDS_MOST * SENT) / 3;
  for (let d = 0; d < digits; d++) {
    const [normal, shear, area] = fingers.subarray(3 * d, 3 * d + 3);
    out.set([normal, shear, area, meanPressure(normal, area)], 4 * d);
  }
  out.set([snapshot.stepCost, snapshot.stepBudget, energy.total, energy.kinetic, energy.elastic], STEP);
}
