"""Types of records, and what is checked of arrays that come in."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

F8 = np.dtype(np.float64)

#: Parts of a hand, in the order of ``Hand.loads``.
PARTS = ("palm", "thumb", "index", "middle", "ring", "little")

#: A record of ``World.contacts``. ``bodies``: A and B, indices into ``World.bodies``. ``vertices``: the vertex of each
#: one's surface that is nearest, -1 for a rigid body. ``point`` [m], ``normal`` (unit, from B to A), ``force`` on A,
#: on B the opposite [N], ``slip``: velocity of A along B [m/s], all in the world. ``gap`` [m], negative inside.
#: ``area`` that the point stands for [m²], 0 between rigid bodies. ``friction``: coefficient. ``slips``: friction
#: gives all it can.
CONTACT: np.dtype[np.void] = np.dtype(
    [
        ("bodies", np.int32, (2,)),
        ("vertices", np.int32, (2,)),
        ("point", F8, (3,)),
        ("normal", F8, (3,)),
        ("force", F8, (3,)),
        ("slip", F8, (3,)),
        ("gap", F8),
        ("area", F8),
        ("friction", F8),
        ("slips", np.bool_),
    ],
    align=True,
)

#: A record of ``Hand.loads``: what presses on a part of a hand. ``normal``: sum of normal forces [N]. ``shear``: size
#: of the summed tangential force [N]. ``area`` in contact [m²]. ``pressure``: mean on the skin [Pa]. ``force`` on the
#: part, world [N]; ``centre`` of pressure, world [m]. ``bone_force`` [N] and ``bone_torque`` [N m]: what the flesh
#: puts on the part's bones, world, about the last bone's centre of mass.
LOAD: np.dtype[np.void] = np.dtype(
    [
        ("normal", F8),
        ("shear", F8),
        ("area", F8),
        ("pressure", F8),
        ("force", F8, (3,)),
        ("centre", F8, (3,)),
        ("bone_force", F8, (3,)),
        ("bone_torque", F8, (3,)),
    ]
)


def numbers(name: str, value: npt.ArrayLike, shape: tuple[int, ...]) -> npt.NDArray[np.float64]:
    """The numbers of an array of this shape; -1 stands for any length."""
    array: npt.NDArray[Any] = np.asarray(value)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name}: expected real numbers, got {array.dtype}")
    if array.ndim != len(shape) or any(want not in (-1, got) for want, got in zip(shape, array.shape)):
        told = ", ".join("n" if n == -1 else str(n) for n in shape) + ("," if len(shape) == 1 else "")
        raise ValueError(f"{name}: expected an array of shape ({told}), got {array.shape}")
    return np.ascontiguousarray(array, dtype=F8)
