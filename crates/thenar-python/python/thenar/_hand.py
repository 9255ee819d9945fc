"""Hands."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _thenar
from ._arrays import F8, LOAD, numbers
from ._body import SoftBody
from ._fields import documented
from ._taxels import Taxels, make
from ._view import View, Views


@documented
class Angle(NamedTuple):
    """Name and range of a joint angle of a hand.

    ``joint``: name of the joint.
    ``rest``: angle at rest [rad].
    ``min``: smallest that is admissible [rad].
    ``max``: largest that is admissible [rad].
    """

    joint: str
    rest: float
    min: float
    max: float


@documented
class Grip(NamedTuple):
    """What a hand grips.

    ``kind``: ``"pinch"``, ``"tripod"``, ``"power"``, ``"hook"`` or ``"lateral"``.
    ``phase``: ``"reaching"``, ``"closing"``, ``"holding"`` or ``"opening"``; ``"idle"`` before the first step.
    ``wanted``: force of the two sides against each other that was asked for [N].
    ``force``: the same as it is felt [N]: half of the sum of the normal forces between the object and the digits that
        take part.
    ``trouble``: what is amiss, in a sentence; None where nothing is.
    """

    kind: str
    phase: str
    wanted: float
    force: float
    trouble: str | None


class Hand:
    """A hand of a world: bones, flesh, and what presses on it."""

    __slots__ = ("_native", "_index", "_known", "_flesh", "_views", "_angles")

    def __init__(self, native: Any, index: int, known: dict[str, Any], flesh: SoftBody | None) -> None:
        self._native = native
        self._index = index
        self._known = known
        self._flesh = flesh
        self._views = Views(native, index)
        self._angles = tuple(angle and Angle(**angle) for angle in known["angles"])

    @property
    def name(self) -> str:
        """Name in the scene."""
        return str(self._known["name"])

    @property
    def side(self) -> str | None:
        """``"left"``, ``"right"``, or None where the model does not say."""
        side: str | None = self._known["side"]
        return side

    @property
    def length(self) -> float:
        """Wrist to middle fingertip at rest [m]."""
        return float(self._known["length"])

    @property
    def flesh(self) -> SoftBody:
        """The deformable body that it is made of. Raises :class:`ValueError` for a hand without flesh."""
        if self._flesh is None:
            raise ValueError(f"hand `{self.name}` has no flesh")
        return self._flesh

    @property
    def nodes(self) -> View[np.float64]:
        """Nodes of its flesh, world, ``(N, 3)`` [m]."""
        return self.flesh.nodes

    @property
    def velocities(self) -> View[np.float64]:
        """Velocities of the nodes, world, ``(N, 3)`` [m/s]."""
        return self.flesh.velocities

    @property
    def vertices(self) -> View[np.float64]:
        """Vertices of the skin that touches, world, ``(V, 3)`` [m]."""
        return self.flesh.vertices

    @property
    def surface(self) -> npt.NDArray[np.uint32]:
        """Corners of the skin's triangles as rows of ``vertices``, counter-clockwise from outside, ``(T, 3)``."""
        return self.flesh.triangles

    @property
    def vertex_force(self) -> View[np.float64]:
        """Contact force on each vertex of the skin in the last step, world, ``(V, 3)`` [N]."""
        return self.flesh.vertex_force

    @property
    def vertex_pressure(self) -> View[np.float64]:
        """Contact pressure at each vertex of the skin, ``(V,)`` [Pa]."""
        return self.flesh.vertex_pressure

    @property
    def bone_names(self) -> tuple[str, ...]:
        """Names of the bones, the palm first; B of them."""
        return tuple(self._known["bones"])

    @property
    def bone_parts(self) -> tuple[str, ...]:
        """The part of the hand that each bone is in, one of ``thenar.PARTS``."""
        return tuple(self._known["digits"])

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints: that of bone i is number i - 1."""
        return tuple(self._known["joints"])

    @property
    def bone_poses(self) -> View[np.float64]:
        """Poses of the bones' frames in the world, ``(B, 7)``: position [m], quaternion x, y, z, w.

        A bone's frame has its origin at the centre of mass, -z along the bone away from the wrist and +y out of the
        back of the hand.
        """
        return self._views.get("bone_poses", F8, (-1, 7))

    @property
    def bone_velocities(self) -> View[np.float64]:
        """Velocities [m/s] and angular velocities [rad/s] of the bones, world, ``(B, 6)``."""
        return self._views.get("bone_velocities", F8, (-1, 6))

    @property
    def wrist(self) -> View[np.float64]:
        """Pose of the wrist's frame in the world, ``(7,)``: -z towards the fingers, +y out of the back."""
        return self._views.get("wrist", F8, (7,))

    @property
    def angles(self) -> View[np.float64]:
        """The twenty angles as the simulation has them, ``(20,)`` [rad]; NaN for a joint that the hand lacks.

        For each finger, thumb first: flexion and spread of its base joint, then flexion of its second and third.
        Flexion is positive when the hand closes, spread away from the middle finger (middle finger: towards the
        thumb; thumb: out of the palm).
        """
        return self._views.get("angles", F8, (20,))

    @property
    def angle_ranges(self) -> tuple[Angle | None, ...]:
        """Joint, rest and range of each of the twenty angles; None for one that the hand lacks."""
        return self._angles

    @property
    def loads(self) -> View[np.void]:
        """Loads on palm, thumb, index, middle, ring and little finger (``thenar.PARTS``) in the last step.

        Six records of ``thenar.LOAD``, ``(6,)``: ``loads["force"]`` is ``(6, 3)`` [N], world; ``loads["normal"]`` and
        ``loads["shear"]`` [N], ``loads["area"]`` [m²], ``loads["pressure"]`` [Pa], ``loads["centre"]`` [m],
        ``loads["bone_force"]`` [N] and ``loads["bone_torque"]`` [N m].
        """
        return self._views.get("loads", LOAD, (6,))

    def __repr__(self) -> str:
        return f"<Hand {self.name}>"


class LiveHand(Hand):
    """A hand that may be moved: one of a :class:`thenar.World`."""

    __slots__ = ()
    _native: _thenar.World

    def follow(
        self, joints: npt.ArrayLike, radii: npt.ArrayLike | None = None, *, time: float | None = None
    ) -> None:
        """Follows a tracked hand: the 25 joints of WebXR Hand Input.

        ``joints``: ``(25, 7)``, poses in the world: position [m], quaternion x, y, z, w; -z along the bone away from
        the wrist, +y out of the back. ``radii``: ``(25,)`` [m], 0 to 0.5; taken for 0 when left out, they move nothing.
        ``time``: when the pose was taken, by any clock [s]; the world's own time when left out.

        The pose acts from the next step on. It is carried over to the hand's own bones, smoothed, carried forward and
        followed at limited speed, as poses of a headset are; one older than 0.1 s counts as lost, and the hand holds
        still. Raises :class:`thenar.PoseError`; nothing has changed then.
        """
        rows = numbers("joints", joints, (25, 7))
        sizes = numbers("radii", np.zeros(25) if radii is None else radii, (25,))
        self._native.follow_joints(self._index, rows.tobytes(), sizes.tobytes(), time)

    def follow_angles(self, wrist: npt.ArrayLike, angles: npt.ArrayLike, *, time: float | None = None) -> None:
        """Follows a wrist and twenty joint angles, as :meth:`follow` does.

        ``wrist``: ``(7,)``, as :attr:`wrist`. ``angles``: ``(20,)`` [rad], as :attr:`angles`; what is out of range is
        brought to its end, and NaN is taken only for angles that the hand lacks.
        """
        pose = numbers("wrist", wrist, (7,))
        wanted = numbers("angles", angles, (20,)).copy()
        lacking = [k for k, angle in enumerate(self._angles) if angle is None]
        wanted[lacking] = 0.0
        self._native.follow_angles(self._index, pose.tobytes(), wanted.tobytes(), time)

    def reaching(
        self, wrist: npt.ArrayLike, tips: Mapping[str, npt.ArrayLike]
    ) -> tuple[npt.NDArray[np.float64], float]:
        """Finds the angles with which fingertips come to places, by inverse kinematics on this hand.

        ``wrist``: ``(7,)``, as :attr:`wrist`. ``tips``: where the middle of each pad is wanted, by finger
        (``"thumb"`` to ``"little"``), ``(3,)`` each, world [m]. Returns ``(20,)`` angles [rad] for :meth:`follow_angles`, and how far
        the worst pad ends from its place [m]. Other fingers are at rest.
        """
        pose = numbers("wrist", wrist, (7,))
        fingers = ("thumb", "index", "middle", "ring", "little")
        places = np.full((5, 3), np.nan)
        for finger, place in tips.items():
            if finger not in fingers:
                raise ValueError(f"no finger is named {finger!r}; there are {', '.join(fingers)}")
            places[fingers.index(finger)] = numbers(f"tips[{finger!r}]", place, (3,))
            if not np.isfinite(places[fingers.index(finger)]).all():
                raise ValueError(f"tips[{finger!r}]: not finite")
        angles, misses = self._native.reaching(self._index, pose.tobytes(), places.tobytes())
        return np.frombuffer(angles, dtype="<f8").copy(), max(misses)

    def taxels(
        self,
        layout: str | Mapping[str, npt.ArrayLike] = "fingertips",
        *,
        rows: int = 4,
        columns: int = 4,
        reach: float = math.inf,
    ) -> Taxels:
        """Puts taxels on the skin, to be read after each step; they change nothing in the simulation.

        ``layout``: ``"fingertips"`` (a patch on the pad of each last finger bone) or ``"hand"`` (a patch on the palm's
        side of every bone), each of so many ``rows`` and ``columns``; or points of one's own: for names of bones
        ``(P, 3)`` points in the bone's frame at rest [m], each of which goes to the nearest place of the skin of the
        bone's part. The first shear axis of a taxel points along its bone, away from the wrist.

        ``reach``: contacts farther from the nearest taxel, at rest, are felt by none [m]; see :attr:`Taxels.missed`.
        Raises :class:`ValueError`: no such layout or bone, a point that is not finite.
        """
        return make(self._native, self._index, layout, rows, columns, float(reach))

    def lose(self) -> None:
        """The hand is not tracked any more: it holds still until the next pose."""
        self._native.lose(self._index)

    def follow_script(self) -> None:
        """Goes back to the scene's script."""
        self._native.follow_script(self._index)

    def lead(self, poses: npt.ArrayLike, velocities: npt.ArrayLike | None = None) -> None:
        """Drives the bones straight to these poses from the next step on, whatever script and poses say.

        ``poses``: ``(B, 7)`` as :attr:`bone_poses`. ``velocities``: ``(B, 6)`` as :attr:`bone_velocities`, zero when
        left out. Nothing is smoothed; the drives are springs, so that contact holds the hand back. A hand that is led
        is weightless. Raises :class:`thenar.PoseError`; nothing has changed then.
        """
        count = len(self._known["bones"])
        rows = numbers("poses", poses, (count, 7))
        rates = numbers("velocities", np.zeros((count, 6)) if velocities is None else velocities, (count, 6))
        norms = np.linalg.norm(rows[:, 3:], axis=1)
        if not (np.abs(norms - 1.0) <= 1e-2).all():
            bad = int(np.argmax(~(np.abs(norms - 1.0) <= 1e-2)))
            name = self._known["bones"][bad]
            raise _thenar.PoseError(f"the quaternion of {name} has length {norms[bad]:.4f}, expected 1")
        rows = rows.copy()
        rows[:, 3:] /= norms[:, None]
        if not self._native.lead(self._index, np.hstack([rows, rates]).tobytes()):
            raise _thenar.PoseError(f"hand `{self.name}` cannot be led: it has no drives, or a number is not finite")

    def grip(self, object: str | None = None, *, kind: str = "pinch", force: float | None = None) -> str:
        """Grips a body from the next step on, with fingers that find their places on it by themselves.

        ``object``: a rigid or soft body by name; left out, the one that is nearest to the pads, within 0.12 m. ``kind``:
        ``"pinch"`` (thumb and index finger), ``"tripod"`` (and middle finger), ``"power"`` (thumb and all fingers),
        ``"lateral"`` (thumb and side of the index finger) or ``"hook"`` (fingers bent around a rigid handle). ``force``: with which
        the two sides press against each other [N]; left out, twice what keeps the object from slipping under its weight, and more as load
        asks; of a hook half of its weight.

        Returns the body's name. The wrist, at most 30 mm aside, and fingers that take no part go on following script or poses; a hand that
        grips opens first. How it goes on tells :attr:`grip_state`. Raises :class:`thenar.GripError`: no such body, or the
        hand cannot grip so; nothing has changed then.
        """
        return self._native.grip(self._index, object, kind, None if force is None else float(force))

    def release(self) -> None:
        """Opens the hand, if it grips, within half a second: its fingers and wrist go back to script or poses."""
        self._native.release(self._index)

    @property
    def grip_state(self) -> Grip | None:
        """What the hand grips, of the scene's grips and those of :meth:`grip`; None while it grips nothing."""
        state = self._native.grip_state(self._index)
        return None if state is None else Grip(*state)

    def let_go(self) -> None:
        """Leads the hand no more: its script or its poses move it, from where it is."""
        self._native.let_go(self._index)

    @property
    def mover(self) -> str:
        """The hand's mover: ``"script"``, ``"live"`` (poses, or who leads it), or ``"lost"`` (it holds still)."""
        return self._native.mover(self._index)
