// A toy simulation answers commands late; the wanted step must be met all the same.

import { describe, expect, it } from "vitest";
import { PauseAt } from "../../src/ui/pause-at";
import type { Command } from "../../src/protocol/types";

/** Runs until done; `delay` snapshots pass before a command acts, and every `lose`-th is lost. */
function run(target: number, start: number, delay: number, lose = 0): number {
  const step = 1 / 60;
  let steps = Math.round(start / step);
  let paused = false;
  let sent = 0;
  const line: { at: number; command: Command }[] = [];
  const pauseAt = new PauseAt(target);
  for (let tick = 0; tick < 20000; tick++) {
    while (line.length > 0 && line[0].at <= tick) {
      const command = line.shift()!.command;
      if (command.type === "run") paused = command.paused;
      if (command.type === "reset") steps = 0;
      if (command.type === "step" && paused) steps += 1;
    }
    if (!paused) steps += 1;
    const command = pauseAt.next({ time: steps * step, paused, step, now: tick * 16 });
    if (pauseAt.done) return steps * step;
    sent += command === null ? 0 : 1;
    if (command !== null && (lose === 0 || sent % lose !== 0)) line.push({ at: tick + delay, command });
  }
  return NaN;
}

describe("pause at a moment", () => {
  const near = (target: number, time: number) => Math.abs(time - target) <= 0.5 / 60 + 1e-9;

  it("stops at the nearest step, whatever the delay", () => {
    for (const delay of [1, 2, 5]) {
      for (const target of [0.05, 0.5, 2.1, 4]) {
        expect(near(target, run(target, 0, delay)), `delay ${delay}, target ${target}`).toBe(true);
      }
    }
  });

  it("goes back to the start if the moment is past", () => {
    expect(near(1, run(1, 3, 2))).toBe(true);
  });

  it("survives lost commands", () => {
    expect(near(1.5, run(1.5, 0, 2, 3))).toBe(true);
  });

  it("a long delay overshoots, starts again and still ends", () => {
    expect(Number.isNaN(run(1, 0, 8))).toBe(false);
  });
});
