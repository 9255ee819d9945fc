"""The cross-entropy method learns how to grip a loaf of bread so that it can be lifted, with numpy alone.

A grip is five numbers: where the wrist goes down to (x, y, z) [m], how far the fingers close, and how many steps they take
for it. Each generation tries as many as are asked for, keeps the best quarter, and draws the next around these. One
process takes some minutes; several share the tries, with the same results.

    python learn_lift.py --csv learned.csv --processes 2
"""

from __future__ import annotations

import argparse
import csv
import pathlib
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from thenar.gym import SQUEEZE_STEP, WRIST_STEP, Lift

Array = npt.NDArray[np.float64]

NAMES = ("x", "y", "z", "squeeze", "closing")
#: Where the search begins: too high above the bread, too far to the side, and too loose; and how widely it looks.
MEAN = np.array([0.05, 0.125, 0.085, 0.4, 40.0])
SPREAD = np.array([0.02, 0.015, 0.015, 0.4, 15.0])
#: No narrower than this, so that it goes on looking.
SPREAD_LEAST = np.array([0.002, 0.0015, 0.0015, 0.04, 2.0])
#: Height of the wrist on the way to the bread and with it [m].
ABOVE, OVER = 0.14, 0.19
#: Largest speed of the wrist, in that of the environment.
SPEED = 0.4


class Generation(NamedTuple):
    """What a generation came to."""

    number: int
    #: Return of the best, and mean of all.
    best: float
    mean: float
    #: Part of the episodes in which the bread was lifted.
    lifted: float
    #: Mean of the best quarter's parameters.
    parameters: list[float]


def episode(env: Lift, grip: Array, seed: int) -> tuple[float, bool]:
    """Goes down, closes and goes up; returns the sum of rewards, and whether the bread was lifted."""
    x, y, z, squeeze, closing = grip
    seen, info = env.reset(seed=seed)
    total, step, done, cut = 0.0, 0, False, False
    closing = max(closing, 1.0)
    closes_at = 80
    goals = ((30, (x, ABOVE, z)), (closes_at + closing + 10, (x, y, z)), (np.inf, (x, OVER, z)))
    while not (done or cut):
        goal = next(place for until, place in goals if step < until)
        move = np.clip((np.array(goal) - seen[23:26]) / WRIST_STEP, -SPEED, SPEED)
        close = squeeze / closing / SQUEEZE_STEP if closes_at <= step < closes_at + closing else 0.0
        seen, reward, done, cut, info = env.step(np.append(move, close).clip(-1.0, 1.0))
        total += reward
        step += 1
    return total, bool(info["is_success"])


_env: list[Lift] = []


def attempt(job: tuple[Array, Sequence[int]]) -> tuple[float, float]:
    """Mean return of a grip over episodes, and the part of them in which it lifted; each process has its own hand."""
    if not _env:
        _env.append(Lift("bread", control="grip"))
    grip, seeds = job
    told = [episode(_env[0], grip, seed) for seed in seeds]
    return float(np.mean([total for total, _ in told])), float(np.mean([lifted for _, lifted in told]))


def learn(
    generations: int = 10, tries: int = 20, seeds: int = 1, processes: int = 1, seed: int = 0
) -> list[Generation]:
    """Learns, and tells what each generation came to. The numbers do not depend on ``processes``."""
    rng = np.random.default_rng(seed)
    mean, spread = MEAN.copy(), SPREAD.copy()
    told: list[Generation] = []
    # Processes begin anew instead of being forked: threads and locks do not outlive a fork.
    pool = ProcessPoolExecutor(processes, mp_context=get_context("spawn")) if processes > 1 else None
    try:
        for number in range(generations):
            grips = mean + spread * rng.standard_normal((tries, len(mean)))
            grips[:, 1] = np.maximum(grips[:, 1], 0.06)  # the table is below
            grips[:, 3:] = np.maximum(grips[:, 3:], [0.0, 1.0])
            # The same coefficients of friction for all tries of a generation.
            episodes = [int(s) for s in rng.integers(0, 2**31, seeds)]
            jobs = [(grip, episodes) for grip in grips]
            results = list(pool.map(attempt, jobs) if pool else map(attempt, jobs))
            returns, lifted = (np.array(column) for column in zip(*results))
            elite = np.argsort(-returns, kind="stable")[: max(2, tries // 4)]
            mean = grips[elite].mean(axis=0)
            spread = np.maximum(grips[elite].std(axis=0), SPREAD_LEAST)
            row = Generation(
                number,
                float(returns.max()),
                float(returns.mean()),
                float(lifted.mean()),
                [float(x) for x in mean],
            )
            told.append(row)
            figures = ", ".join(f"{name} {x:.3f}" for name, x in zip(NAMES, row.parameters))
            print(
                f"{number:3}: best {row.best:6.1f}, mean {row.mean:6.1f}, lifted {row.lifted:4.0%}; {figures}",
                flush=True,
            )
    finally:
        if pool:
            pool.shutdown(cancel_futures=True)
    return told


def write(told: list[Generation], file: pathlib.Path) -> None:
    """Writes the curve."""
    with file.open("w", newline="") as out:
        rows = csv.writer(out, lineterminator="\n")
        rows.writerow(["generation", "best", "mean", "lifted", *NAMES])
        for row in told:
            figures = [f"{x:.4g}" for x in (row.best, row.mean, row.lifted, *row.parameters)]
            rows.writerow([row.number, *figures])


def draw(told: list[Generation], file: pathlib.Path) -> None:
    """Draws the curve: returns, and how often the bread was lifted."""
    import matplotlib

    matplotlib.rcParams["svg.hashsalt"] = "thenar"
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 3.5), layout="constrained")
    axes = figure.subplots()
    numbers = [row.number for row in told]
    for name in ("best", "mean"):
        axes.plot(numbers, [getattr(row, name) for row in told], marker=".", label=f"return, {name}")
    axes.set_xlabel("generation")
    axes.set_ylabel("return of an episode")
    other = axes.twinx()
    other.bar(numbers, [100 * row.lifted for row in told], width=0.5, color="0.85", zorder=0)
    other.set_ylabel("lifted [% of the episodes]")
    other.set_ylim(0, 100)
    axes.set_zorder(other.get_zorder() + 1)
    axes.patch.set_visible(False)
    axes.legend(loc="lower right")
    figure.savefig(file, metadata={"Date": None} if file.suffix == ".svg" else None)


def main() -> None:
    """The command line."""
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("--generations", type=int, default=10)
    options.add_argument("--tries", type=int, default=20, help="grips in a generation")
    options.add_argument("--seeds", type=int, default=1, help="episodes of each grip")
    options.add_argument("--processes", type=int, default=1)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--picture", type=pathlib.Path, help="draw the curve into this file; needs matplotlib")
    options.add_argument("--csv", type=pathlib.Path, help="write the curve to this file")
    asked = options.parse_args()
    told = learn(asked.generations, asked.tries, asked.seeds, asked.processes, asked.seed)
    if asked.csv:
        write(told, asked.csv)
    if asked.picture:
        draw(told, asked.picture)


if __name__ == "__main__":
    main()
