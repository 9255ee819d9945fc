"""How a batch of hands scales: steps per second on one thread and on more, by the clock and by processor time.

    python many_hands.py --hands 64 --steps 20 --turns 30

They take turns. By the clock other jobs count, so the quickest turn of each is told; processor time tells what threads cost each other.
"""

from __future__ import annotations

import argparse
import os
import time
from typing import NamedTuple

import thenar


class Row(NamedTuple):
    """What so many threads did, of all turns the best."""

    threads: int
    #: Steps of one hand per second by the clock.
    steps_per_second: float
    #: Processor time for a step of one hand [s].
    processor: float


def press(hands: int) -> list[thenar.World]:
    """Hands of 590 tetrahedra that press on a table, 5 ms a step, each in a world of its own."""
    scene = thenar.Scene.named("table-press", set={"hand.0.preset": "paper", "time_step": 0.005})
    first = scene.world()
    while first.step(10).contacts_active == 0:
        pass
    first.step(40)
    state = first.state()
    worlds = [scene.world() for _ in range(hands)]
    for world in worlds:
        world.set_state(state)
    return worlds


def measure(hands: int, steps: int, turns: int, threads: list[int]) -> list[Row]:
    """Steps the same presses by each number of threads, turn by turn."""
    worlds = press(hands)
    states = [world.state() for world in worlds]
    best = {count: (float("inf"), float("inf")) for count in threads}
    for _ in range(turns):
        for count in threads:
            for world, state in zip(worlds, states):
                world.set_state(state)
            batch = thenar.Batch(worlds, threads=count)
            batch.step(2)
            wall, processor = time.perf_counter(), time.process_time()
            batch.step(steps)
            took = (time.perf_counter() - wall, time.process_time() - processor)
            best[count] = (min(best[count][0], took[0]), min(best[count][1], took[1]))
    made = hands * steps
    return [Row(count, made / wall, processor / made) for count, (wall, processor) in best.items()]


def main() -> None:
    """Prints a table."""
    parser = argparse.ArgumentParser(description="How a batch of hands scales.")
    parser.add_argument("--hands", type=int, default=64)
    parser.add_argument("--steps", type=int, default=20, help="of each hand, in one call")
    parser.add_argument("--turns", type=int, default=20)
    parser.add_argument("--threads", type=int, nargs="+", default=[1, os.cpu_count() or 1])
    options = parser.parse_args()
    rows = measure(options.hands, options.steps, options.turns, options.threads)
    print("threads  steps per second  times the first  processor time per step [ms]")
    for row in rows:
        times = row.steps_per_second / rows[0].steps_per_second
        print(f"{row.threads:7d}  {row.steps_per_second:16.0f}  {times:15.2f}  {1e3 * row.processor:28.3f}")


if __name__ == "__main__":
    main()
