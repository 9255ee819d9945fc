"""Bodies of a world."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._arrays import F8
from ._view import Source, View, Views


class Native(Source):
    """The common part of a world and a recording."""

    def triangles(self, soft: int) -> bytes:
        raise NotImplementedError


class RigidBody:
    """A rigid body; a hand's bones are some."""

    __slots__ = ("_index", "_name", "_views")

    def __init__(self, native: Source, name: str, index: int) -> None:
        self._index = index
        self._name = name
        self._views = Views(native, index)

    @property
    def name(self) -> str:
        """Name in the scene; of a bone ``hand/bone``."""
        return self._name

    @property
    def pose(self) -> View[np.float64]:
        """Pose of the body's frame, whose origin is the centre of mass, in the world, ``(7,)``: position [m],
        quaternion x, y, z, w."""
        return self._views.get("pose", F8, (7,))

    @property
    def velocity(self) -> View[np.float64]:
        """Velocity of the centre of mass [m/s] and angular velocity [rad/s], world, ``(6,)``."""
        return self._views.get("velocity", F8, (6,))

    def __repr__(self) -> str:
        return f"<RigidBody {self._name}>"


class SoftBody:
    """A deformable body: tetrahedra with a surface that touches. A hand's flesh is one."""

    __slots__ = ("_name", "_native", "_index", "_views", "_triangles")

    def __init__(self, native: Any, name: str, index: int) -> None:
        self._native = native
        self._name = name
        self._index = index
        self._views = Views(native, index)
        self._triangles: npt.NDArray[np.uint32] | None = None

    @property
    def name(self) -> str:
        """Name in the scene."""
        return self._name

    @property
    def nodes(self) -> View[np.float64]:
        """Nodes of the tetrahedra, world, ``(N, 3)`` [m]."""
        return self._views.get("nodes", F8, (-1, 3))

    @property
    def velocities(self) -> View[np.float64]:
        """Velocities of the nodes, world, ``(N, 3)`` [m/s]."""
        return self._views.get("node_velocities", F8, (-1, 3))

    @property
    def vertices(self) -> View[np.float64]:
        """Vertices of the surface that touches, world, ``(V, 3)`` [m]."""
        return self._views.get("vertices", F8, (-1, 3))

    @property
    def triangles(self) -> npt.NDArray[np.uint32]:
        """Corners of the surface's triangles as rows of ``vertices``, counter-clockwise from outside, ``(T, 3)``.

        They never change: this is one array, read-only.
        """
        if self._triangles is None:
            self._triangles = np.frombuffer(self._native.triangles(self._index), dtype=np.uint32).reshape(-1, 3)
        return self._triangles

    @property
    def vertex_force(self) -> View[np.float64]:
        """Contact force on each vertex of the surface in the last step, world, ``(V, 3)`` [N]."""
        return self._views.get("vertex_forces", F8, (-1, 3))

    @property
    def vertex_pressure(self) -> View[np.float64]:
        """Contact pressure at each vertex: normal force over the area that it stands for, ``(V,)`` [Pa]."""
        return self._views.get("vertex_pressures", F8, (-1,))

    def __repr__(self) -> str:
        return f"<SoftBody {self._name}>"
