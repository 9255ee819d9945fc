"""Many worlds at once."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterable, Iterator, Sequence
from typing import overload

from . import _thenar
from ._thenar import StepReport
from ._world import World


class Batch(Sequence[World]):
    """Worlds that are stepped together, on threads of this process, with the same bits as alone.

    ``threads``: how many at most; as many as the processor has when left out. The worlds stay usable one by one.
    """

    __slots__ = ("_worlds", "_threads")

    def __init__(self, worlds: Iterable[World], *, threads: int | None = None) -> None:
        self._worlds = tuple(worlds)
        if len({id(world._native) for world in self._worlds}) < len(self._worlds):
            raise ValueError("a world is in the batch twice")
        self._threads = (os.cpu_count() or 1) if threads is None else operator.index(threads)
        if self._threads < 1:
            raise ValueError(f"threads: expected 1 or more, got {self._threads}")

    def step(self, n: int = 1) -> list[StepReport]:
        """Makes ``n`` steps of each world and returns the reports of their last.

        Other Python threads run meanwhile. Ctrl-C stops each world between two steps, with
        :class:`KeyboardInterrupt`; they may have made different numbers of steps then. Where another thread steps one
        of the worlds, none is stepped: :class:`thenar.BusyError`.
        """
        n = operator.index(n)
        if n < 0:
            raise ValueError(f"n: expected 0 or more steps, got {n}")
        return _thenar.step_all([world._native for world in self._worlds], n, self._threads)

    def __len__(self) -> int:
        return len(self._worlds)

    @overload
    def __getitem__(self, index: int) -> World: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[World, ...]: ...

    def __getitem__(self, index: int | slice) -> World | tuple[World, ...]:
        return self._worlds[index]

    def __iter__(self) -> Iterator[World]:
        return iter(self._worlds)

    def __repr__(self) -> str:
        return f"<Batch of {len(self._worlds)} worlds on {self._threads} threads>"
