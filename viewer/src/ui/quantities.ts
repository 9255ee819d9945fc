// What is plotted: force, area and pressure per digit of a hand, or per body where no hand is, and what the step costs.

import { DIGITS, PER_DIGIT, PER_HAND, type Snapshot } from "../protocol/types";

/** Colours that differ for colour-blind eyes too (after Okabe and Ito), on light and dark. */
export const DIGIT_COLOURS = ["#8d97a5", "#e0651a", "#d99a00", "#00a37a", "#3d9fe0", "#c56fa3"] as const;
export const DIGIT_LABELS = DIGITS.map((digit) => digit[0].toUpperCase() + digit.slice(1));

export const HANDS_MOST = 2;
const STEP = HANDS_MOST * PER_HAND;
export const COLUMNS = STEP + 5;

/** What has a row of numbers and a curve: a digit, or a body. */
export interface Part {
  readonly label: string;
  readonly colour: string;
  readonly dashed?: boolean;
}

export const DIGIT_PARTS: readonly Part[] = DIGIT_LABELS.map((label, d) => ({ label, colour: DIGIT_COLOURS[d] }));

/** Bodies in the digits' colours; dashed from where these come again. */
export function bodyParts(names: readonly string[]): Part[] {
  const colours = DIGIT_COLOURS.length;
  // The first body is what the scene is about: the first colour of a finger, not the palm's grey.
  return names.map((label, i) => ({ label, colour: DIGIT_COLOURS[(i + 1) % colours], dashed: i >= colours }));
}

export interface Curve extends Part {
  readonly column: number;
}

export interface Quantity {
  readonly id: string;
  readonly label: string;
  readonly unit: string;
  /** Shown value over SI value. */
  readonly factor: number;
  /** Top of the scale at least, in shown units. */
  readonly least: number;
  /** One curve for each part; else it is of the whole scene. */
  readonly perPart: boolean;
  /** Of parts whose numbers begin at a column. */
  curves(first: number, parts: readonly Part[]): readonly Curve[];
}

function perPart(
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
    perPart: true,
    curves: (first, parts) => parts.map((part, d) => ({ ...part, column: first + PER_DIGIT * d + k })),
  };
}

export const QUANTITIES: readonly Quantity[] = [
  perPart("normal", "Normal force", "N", 1, 0.5, 0),
  perPart("shear", "Shear force", "N", 1, 0.5, 1),
  perPart("area", "Contact area", "mm²", 1e6, 50, 2),
  perPart("pressure", "Mean pressure", "kPa", 1e-3, 5, 3),
  {
    id: "cost",
    label: "Step time",
    unit: "ms",
    factor: 1,
    least: 1,
    perPart: false,
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
    perPart: false,
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
