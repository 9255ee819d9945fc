"""Sweeps as arrays of Slurm jobs: task K of N runs shard K/N of ``thenar sweep``."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
from collections.abc import Mapping, Sequence


def slurm_shard(environ: Mapping[str, str] | None = None) -> tuple[int, int]:
    """The shard (K, N) of the present task of an array, from ``SLURM_ARRAY_TASK_ID``, ``_MIN``, ``_MAX`` and ``_COUNT``.

    Only of a whole array without gaps: one of which single tasks were submitted again says neither how many there
    were nor which these are. :func:`slurm_script` writes N down instead.

    Raises :class:`ValueError`: this is no task of an array, or the array has gaps.
    """
    environ = os.environ if environ is None else environ
    numbers = []
    for word in ("ID", "MIN", "MAX", "COUNT"):
        name = f"SLURM_ARRAY_TASK_{word}"
        if not re.fullmatch(r"[0-9]+", environ.get(name, "")):
            raise ValueError(f"{name}: expected a whole number, got {environ.get(name)!r}")
        numbers.append(int(environ[name]))
    task, first, last, count = numbers
    if last - first + 1 != count or not first <= task <= last:
        raise ValueError(f"the array has gaps: {count} tasks from {first} to {last}")
    return task - first + 1, count


def slurm_script(arguments: Sequence[str], *, shards: int, threads: int = 1, options: Sequence[str] = ()) -> str:
    """A batch script for ``sbatch``: an array of ``shards`` tasks, each with ``threads`` cores.

    ``arguments``: those of ``thenar sweep`` without ``--shard`` and ``--threads``; ``options``: of ``sbatch``, as
    ``"--time=01:00:00"``. A task that is cut, by its time limit or by a node that dies, goes on where it was when it
    is submitted again, alone or with the others: ``sbatch --array=3,7 script``.

    Raises :class:`ValueError`: a number is less than 1, or an option is no option on one line.
    """
    if shards < 1 or threads < 1:
        raise ValueError(f"expected 1 or more shards and threads, got {shards} and {threads}")
    for taken in ("--shard", "--threads"):
        if any(word == taken or word.startswith(taken + "=") for word in arguments):
            raise ValueError(f"arguments: {taken} is chosen here")
    for option in options:
        if not option.startswith("-") or not option.isprintable():
            raise ValueError(f"options: expected an option such as --time=01:00:00, got {option!r}")
    # Slurm reads its options from comments before the first command.
    header = [f"--array=1-{shards}", f"--cpus-per-task={threads}", "--requeue", *options]
    sweep = shlex.join(["thenar", "sweep", *arguments])
    return "\n".join(
        [
            "#!/bin/bash",
            *(f"#SBATCH {option}" for option in header),
            # Slurm's signal reaches the program itself, which ends between two steps.
            f'exec {sweep} --threads {threads} --shard "$SLURM_ARRAY_TASK_ID/{shards}"',
            "",
        ]
    )


def slurm_submit(script: str) -> str:
    """Hands a script to ``sbatch`` and returns the job's number.

    Raises :class:`RuntimeError` with what ``sbatch`` said where it refuses, :class:`FileNotFoundError` where there is none.
    """
    done = subprocess.run(["sbatch", "--parsable"], input=script, text=True, capture_output=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"sbatch: {done.stderr.strip() or f'exit code {done.returncode}'}")
    # Of a federation the cluster's name follows.
    return done.stdout.strip().split(";")[0]
