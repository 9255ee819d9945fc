"""Arrays of a world that know of which step they are."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
import numpy.typing as npt
from numpy.lib.mixins import NDArrayOperatorsMixin

T = TypeVar("T", bound=np.generic)


class Source(Protocol):
    """Where views read: a world, or a recording that is made again."""

    def generation(self) -> int: ...

    def read(self, what: str, index: int, generation: int) -> bytes | memoryview: ...


class View(NDArrayOperatorsMixin, Generic[T]):
    """An array of the present step, read when it is first asked for.

    ``view.array``, ``np.asarray(view)``, ``view[...]`` and arithmetic give the numbers; all share one array, which
    is read-only and never changes. Once the world is stepped, reset or put into another state, the view is *stale*
    and raises :class:`thenar.StaleViewError`; ask the world for it again. An array that was taken before stays what
    it was: the numbers of its step.

    The numbers are copied once, from the simulation's memory into memory that belongs to the array. Sharing that
    memory itself is not possible soundly: a step writes it while other Python threads run, and nothing could keep
    them from reading an array of it meanwhile.
    """

    __slots__ = ("_source", "_what", "_index", "_dtype", "_shape", "_generation", "_array")

    # Ahead of arrays in arithmetic, so that `array - view` comes here too.
    __array_priority__ = 1.0

    def __init__(
        self, source: Source, what: str, index: int, dtype: np.dtype[T], shape: tuple[int, ...], generation: int
    ) -> None:
        self._source = source
        self._what = what
        self._index = index
        self._dtype = dtype
        self._shape = shape
        self._generation = generation
        self._array: npt.NDArray[T] | None = None

    @property
    def array(self) -> npt.NDArray[T]:
        """The numbers, read-only.

        Raises :class:`thenar.StaleViewError` when the view is stale.
        """
        if self._array is None:
            data = self._source.read(self._what, self._index, self._generation)
            self._array = np.frombuffer(data, dtype=self._dtype).reshape(self._shape)
        elif self.is_stale:
            # Raises the error, in the same words.
            self._source.read(self._what, self._index, self._generation)
        return self._array

    @property
    def is_stale(self) -> bool:
        """True once the world has gone on."""
        return self._source.generation() != self._generation

    @property
    def dtype(self) -> np.dtype[T]:
        """Type of the numbers."""
        return self._dtype

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers along each axis."""
        return self.array.shape

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self._shape)

    @property
    def size(self) -> int:
        """Numbers, or records, in all."""
        return self.array.size

    def copy(self) -> npt.NDArray[T]:
        """The numbers in an array of their own, which may be written."""
        return self.array.copy()

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        array = self.array
        if dtype is not None and np.dtype(dtype) != array.dtype:
            if copy is False:
                raise ValueError(f"a view of {array.dtype} becomes {np.dtype(dtype)} by a copy only")
            return array.astype(dtype)
        return array.copy() if copy else array

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if any(isinstance(out, View) for out in kwargs.get("out", ())):
            raise TypeError("a view is read-only: nothing is written into it")
        arrays = [i.array if isinstance(i, View) else i for i in inputs]
        return getattr(ufunc, method)(*arrays, **kwargs)

    def __getitem__(self, key: Any) -> Any:
        return self.array[key]

    def __len__(self) -> int:
        return len(self.array)

    def __iter__(self) -> Iterator[Any]:
        return iter(self.array)

    def __bool__(self) -> bool:
        return bool(self.array)

    def __repr__(self) -> str:
        if self.is_stale:
            return f"<View of {self._what}, stale>"
        return f"<View of {self._what}: {self.array!r}>"


class Views:
    """The views of one thing, each made once a step."""

    __slots__ = ("_source", "_index", "_known")

    def __init__(self, source: Source, index: int) -> None:
        self._source = source
        self._index = index
        self._known: dict[str, View[Any]] = {}

    def get(self, what: str, dtype: np.dtype[T], shape: tuple[int, ...]) -> View[T]:
        """The present view."""
        generation = self._source.generation()
        known = self._known.get(what)
        if known is None or known._generation != generation:
            known = View(self._source, what, self._index, dtype, shape, generation)
            self._known[what] = known
        return known
