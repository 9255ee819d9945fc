// Facts of the newest step, each with a plain explanation.

import { FLAG, type Snapshot } from "../protocol/types";
import { fixed, significant } from "./format";

/** Less than this is nothing to a reader, mm: a thousandth of what would show. */
const LEAST = 1e-4;

/** A length in millimetres, for one given in metres. */
function millimetres(length: number): string {
  const shown = 1e3 * length;
  return shown > 0 && shown < LEAST ? `below ${LEAST} mm` : `${significant(shown, 2)} mm`;
}

export interface Fact {
  readonly name: string;
  /** For someone who sees it for the first time. */
  readonly help: string;
  value(snapshot: Snapshot): string;
}

export const STEP_FACTS: readonly Fact[] = [
  {
    name: "Step",
    help: "Computing time of a step, in milliseconds, and the time there is for it. Above it the scene runs slower than asked.",
    value: ({ stepCost, stepBudget }) => `${fixed(stepCost, 1)} of ${fixed(stepBudget, 1)} ms`,
  },
  {
    name: "Contacts",
    help: "Number of points at which bodies touch.",
    value: ({ contacts, flags }) => `${contacts.count}${(flags & FLAG.contactsLeftOut) !== 0 ? " and more" : ""}`,
  },
  {
    name: "Solver rounds",
    help:
      "How often the solver went over all contacts in this step (its sweeps) until their forces agreed. " +
      "More rounds cost more computing time; many come where bodies are jammed.",
    value: ({ sweeps }) => String(sweeps),
  },
  {
    name: "Deepest penetration",
    help: "How far bodies are inside each other at most, in millimetres. Above 1 mm it shows, and forces there are doubtful.",
    value: ({ penetration }) => millimetres(penetration),
  },
  {
    name: "Largest joint gap",
    help: "How far the two sides of a joint are apart at most, in millimetres. A hand that holds together stays below 0.05 mm.",
    value: ({ jointGap }) => millimetres(jointGap),
  },
];
