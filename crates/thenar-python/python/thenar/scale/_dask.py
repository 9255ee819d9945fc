"""Cases on Dask."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any

from ._cases import Case, Row, Sweep


def _run(item: tuple[int, list[str]], sweep: Sweep) -> Row:
    number, overrides = item
    return sweep.run_overrides(number, overrides)


def dask_bag(sweep: Sweep, cases: Sequence[Case], *, npartitions: int | None = None) -> Any:
    """A ``dask.bag.Bag`` of rows in the order of the cases; a partition for each case unless said otherwise.

    Nothing is run before ``compute``. Cases leave Python alone while they run, so threads
    (``compute(scheduler="threads")``) use all cores as well as processes do.

    Raises :class:`ValueError`: there is no case; :class:`ImportError` without Dask.
    """
    try:
        bag = importlib.import_module("dask.bag")
    except ImportError as error:
        raise ImportError("cases on Dask need the package dask: pip install thenar[dask]") from error
    if not cases:
        raise ValueError("cases: expected one or more")
    items = [(number, sweep.overrides(case)) for number, case in enumerate(cases)]
    return bag.from_sequence(items, npartitions=npartitions or len(items)).map(_run, sweep=sweep)
