"""Taxels: contact as a skin of sensors feels it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from . import _thenar
from ._arrays import F8, numbers
from ._fields import documented
from ._view import View, Views

#: A record of ``Taxels.read``. ``force``: the taxel's share of contact forces, world [N]. ``normal``: the part of it
#: that presses, against the outward normal n [N]. ``shear``: the parts along its two shear axes [N]. ``area``: its
#: share of the area in contact [m²]. ``pressure``: its share of normal forces on skin over that [Pa]. ``slip``:
#: velocity against what it touches along the shear axes, mean by load [m/s]. ``point``: where it is, world [m].
#: ``axes``: n and the two shear axes as rows, world; they move with the skin.
TAXEL: np.dtype[np.void] = np.dtype(
    [
        ("force", F8, (3,)),
        ("normal", F8),
        ("shear", F8, (2,)),
        ("area", F8),
        ("pressure", F8),
        ("slip", F8, (2,)),
        ("point", F8, (3,)),
        ("axes", F8, (3, 3)),
    ]
)

#: Layouts that come along: on the last bone of each finger, and on every bone.
LAYOUTS = ("fingertips", "hand")


@documented
class Patch(NamedTuple):
    """Taxels on one bone, in rows and columns.

    ``bone``: name of the bone.
    ``rows``: rows, from the wrist outwards.
    ``columns``: columns, along the bone's x axis: to the little finger's side of a right hand, to the thumb's of a left
        one.
    ``start``: where its taxels begin among all.
    """

    bone: str
    rows: int
    columns: int
    start: int

    @property
    def stop(self) -> int:
        """Where they end."""
        return self.start + self.rows * self.columns


class _Source:
    """Reads taxels for views: the taxels, or what they miss."""

    __slots__ = ("_world", "_native")

    def __init__(self, world: _thenar.World, native: _thenar.Taxels) -> None:
        self._world = world
        self._native = native

    def generation(self) -> int:
        return self._world.generation()

    def read(self, what: str, index: int, generation: int) -> memoryview:
        data = memoryview(self._world.read_taxels(self._native, generation))
        # The last record holds what none feels.
        return data[: -TAXEL.itemsize] if what == "taxels" else data[-TAXEL.itemsize :][: 3 * F8.itemsize]


class Taxels:
    """Taxels on a hand; see :meth:`thenar.LiveHand.taxels`.

    Every contact of a part of the hand (a finger, the palm) is given to the taxels of that part, to the four nearest
    at most, in shares that sum to one: whatever the layout, the forces of its taxels and :attr:`missed` sum to the
    contact force on the parts that have taxels.
    """

    __slots__ = ("_patches", "_count", "_views")

    def __init__(self, world: _thenar.World, native: _thenar.Taxels) -> None:
        """For the package itself: use :meth:`thenar.LiveHand.taxels`."""
        self._views = Views(_Source(world, native), 0)
        patches, start = [], 0
        for bone, rows, columns in native.patches():
            patches.append(Patch(bone, rows, columns, start))
            start = patches[-1].stop
        self._patches = tuple(patches)
        self._count = start

    @property
    def patches(self) -> tuple[Patch, ...]:
        """The patches, in the order of the taxels."""
        return self._patches

    def __len__(self) -> int:
        return self._count

    def read(self) -> View[np.void]:
        """Readings of the taxels in the last step, ``(T,)`` records of ``thenar.TAXEL``.

        ``read()["normal"]`` is ``(T,)`` [N], ``read()["shear"]`` ``(T, 2)`` [N], and so on for ``force``, ``area``,
        ``pressure``, ``slip``, ``point`` and ``axes``.
        """
        return self._views.get("taxels", TAXEL, (-1,))

    @property
    def missed(self) -> View[np.float64]:
        """Contact force on parts that have taxels which none of them feels, as it is out of reach, world ``(3,)`` [N]."""
        return self._views.get("missed", F8, (3,))

    def patch(self, bone: str) -> npt.NDArray[np.void]:
        """The records of one patch, ``(rows, columns)``. Raises :class:`KeyError`."""
        for patch in self._patches:
            if patch.bone == bone:
                records: npt.NDArray[np.void] = self.read().array[patch.start : patch.stop]
                return records.reshape(patch.rows, patch.columns)
        raise KeyError(f"there is no patch on `{bone}`: there are {', '.join(p.bone for p in self._patches)}")

    def image(self, bone: str) -> npt.NDArray[np.float64]:
        """Normal and the two shears of a patch, ``(3, rows, columns)`` [N]: one image after another, in the order of
        MuJoCo's ``touch_grid``."""
        patch = self.patch(bone)
        return np.concatenate([patch["normal"][None], np.moveaxis(patch["shear"], -1, 0)])

    def __repr__(self) -> str:
        return f"<Taxels: {self._count} in {len(self._patches)} patches>"


def stack_taxels(taxels: Sequence[Taxels]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Normal forces ``(N, P)`` [N] and shears ``(N, P, 2)`` [N] of N hands with P taxels each.

    These are the shapes of Isaac Lab's tactile sensor: one row for each world of a batch.
    """
    counts = {len(each) for each in taxels}
    if len(counts) != 1:
        raise ValueError(f"expected hands with as many taxels each, got {sorted(counts)}")
    read = [each.read() for each in taxels]
    return np.stack([each["normal"] for each in read]), np.stack([each["shear"] for each in read])


def make(
    world: _thenar.World,
    hand: int,
    layout: str | Mapping[str, npt.ArrayLike],
    rows: int,
    columns: int,
    reach: float,
) -> Taxels:
    """Taxels of a layout, or at points."""
    if isinstance(layout, str):
        if rows < 1 or columns < 1:
            raise ValueError(f"expected 1 or more rows and columns, got {rows} and {columns}")
        return Taxels(world, world.taxels_of(hand, layout, rows, columns, reach))
    points = [(bone, numbers(bone, points, (-1, 3)).tobytes()) for bone, points in layout.items()]
    return Taxels(world, world.taxels_at(hand, points, reach))
