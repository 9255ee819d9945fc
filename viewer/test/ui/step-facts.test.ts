import { expect, test } from "vitest";
import { FLAG, type Snapshot } from "../../src/protocol/types";
import { STEP_FACTS } from "../../src/ui/step-facts";

const snapshot = {
  flags: FLAG.contactsLeftOut,
  stepCost: 2.34,
  stepBudget: 5,
  contacts: { count: 12 },
  sweeps: 7,
  penetration: 1.2e-4,
  jointGap: 0,
} as unknown as Snapshot;

test("facts of a step have units, and words for what they are", () => {
  expect(STEP_FACTS.map((fact) => [fact.name, fact.value(snapshot)])).toEqual([
    ["Step", "2.3 of 5.0 ms"],
    ["Contacts", "12 and more"],
    ["Solver rounds", "7"],
    ["Deepest penetration", "0.12 mm"],
    ["Largest joint gap", "0 mm"],
  ]);
  // Rounding is no gap that a reader could do something with.
  expect(STEP_FACTS[4].value({ ...snapshot, jointGap: 4.2e-17 })).toBe("below 0.0001 mm");
  expect(STEP_FACTS[1].value({ ...snapshot, flags: 0 })).toBe("12");
  // A sentence each, that does more than repeat the name.
  for (const { name, help } of STEP_FACTS) {
    expect(help.length).toBeGreaterThan(2 * name.length);
    expect(help.endsWith(".")).toBe(true);
  }
});
