"""Worlds."""

from __future__ import annotations

import json
import operator
import os
from types import TracebackType
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _thenar
from ._arrays import CONTACT, numbers
from ._body import RigidBody, SoftBody
from ._fields import documented
from ._hand import LiveHand
from ._thenar import StepReport
from ._view import View, Views


def bodies_of(native: Any, known: dict[str, Any]) -> tuple[tuple[RigidBody, ...], tuple[SoftBody, ...]]:
    """The rigid and the deformable bodies of a description."""
    rigids = tuple(RigidBody(native, name, i) for i, name in enumerate(known["rigids"]))
    softs = tuple(SoftBody(native, soft["name"], i) for i, soft in enumerate(known["softs"]))
    return rigids, softs


@documented
class Camera(NamedTuple):
    """An eye that :meth:`World.picture` draws with; +y appears upwards.

    ``position``: place of the eye, world [m].
    ``target``: place that appears in the middle, world [m].
    ``fov_deg``: vertical field of view [deg].
    """

    position: tuple[float, float, float]
    target: tuple[float, float, float]
    fov_deg: float = 34.0


def _size(size: tuple[int, int]) -> tuple[int, int]:
    """A size that the native half can take; what is beyond any is left to it to refuse."""
    width, height = (min(max(edge, 0), 2**32 - 1) for edge in size)
    return width, height


def _eye(camera: Camera | None) -> tuple[float, float, float, float, float, float, float] | None:
    if camera is None:
        return None
    position, target = (numbers(f"camera.{name}", getattr(camera, name), (3,)) for name in ("position", "target"))
    (x, y, z), (a, b, c) = position.tolist(), target.tolist()
    return x, y, z, a, b, c, float(camera.fov_deg)


@documented
class Setting(NamedTuple):
    """A setting of a running world.

    ``key``: name in :meth:`World.set`.
    ``value``: present value: a number, or a word.
    ``unit``: SI unit; empty for words, ``1`` for pure numbers.
    ``help``: what a change does.
    """

    key: str
    value: float | str
    unit: str
    help: str


class Recorder:
    """A recording of a world that is being written; see :meth:`World.record`."""

    __slots__ = ("_native", "_bytes")

    def __init__(self, native: _thenar.World) -> None:
        self._native = native
        self._bytes: int | None = None

    def end(self) -> int:
        """Ends the recording and returns its size [bytes]; once more, it returns the same.

        Raises :class:`thenar.RecordingError` when not all of it could be written.
        """
        if self._bytes is None:
            self._bytes = self._native.end_recording() or 0
        return self._bytes

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end()


class World:
    """A running scene: bodies that are moved, pressed and touched, one time step after another.

    All arrays are views of the present step (:class:`thenar.View`), in SI units and, unless said otherwise, in the
    world's frame, which is right-handed with +y up in the scenes that come along. One thread has a world at a time:
    another that comes meanwhile gets :class:`thenar.BusyError` at once. The same calls give the same bits.
    """

    __slots__ = ("_native", "_views", "_rigids", "_softs", "_hands", "_name", "_overlaps")

    def __init__(self, native: _thenar.World) -> None:
        """For the package itself: use :meth:`Scene.world`."""
        self._native = native
        self._views = Views(native, 0)
        known = json.loads(native.describe())
        self._name = str(known["name"])
        self._overlaps = tuple(str(overlap) for overlap in known["overlaps"])
        self._rigids, self._softs = bodies_of(native, known)
        flesh = [hand["soft"] for hand in known["hands"]]
        self._hands = tuple(
            LiveHand(native, i, hand, None if soft is None else self._softs[soft])
            for i, (hand, soft) in enumerate(zip(known["hands"], flesh))
        )

    def step(self, n: int = 1) -> StepReport:
        """Makes ``n`` steps and returns the report of the last.

        Other Python threads run meanwhile, and Ctrl-C ends it between two steps with :class:`KeyboardInterrupt`; the
        steps made until then count. ``n = 0`` changes nothing and returns the last report.
        """
        n = operator.index(n)
        if n < 0:
            raise ValueError(f"n: expected 0 or more steps, got {n}")
        return self._native.step(n)

    def reset(self) -> None:
        """Back to the start: time 0, bodies in their start states, scripts from the beginning.

        Settings stay, and so does who leads the hands, with calibration and clock: for the same bits as at first, go
        back to a :meth:`state` that was taken there by :meth:`set_state`.
        """
        self._native.reset()

    @property
    def name(self) -> str:
        """The scene file's name without folder and ending."""
        return self._name

    @property
    def time(self) -> float:
        """Time simulated since the start [s]."""
        return self._native.progress()[0]

    @property
    def steps(self) -> int:
        """Steps since the start."""
        return self._native.progress()[1]

    @property
    def steps_taken_back(self) -> int:
        """Steps so far, resets included, that gave a number that is not finite and were taken back."""
        return self._native.progress()[2]

    @property
    def time_step(self) -> float:
        """Time step [s]."""
        return self._native.time_step()

    @property
    def report(self) -> StepReport:
        """The report of the last step."""
        return self._native.report()

    @property
    def overlaps(self) -> tuple[str, ...]:
        """Bodies that the scene starts inside each other, the deepest first, in words."""
        return self._overlaps

    @property
    def hands(self) -> tuple[LiveHand, ...]:
        """The hands, in the order of the scene."""
        return self._hands

    @property
    def rigid_bodies(self) -> tuple[RigidBody, ...]:
        """The rigid bodies, hands' bones included."""
        return self._rigids

    @property
    def soft_bodies(self) -> tuple[SoftBody, ...]:
        """The deformable bodies, hands' flesh included."""
        return self._softs

    @property
    def bodies(self) -> tuple[RigidBody | SoftBody, ...]:
        """The rigid bodies, then the deformable ones: contacts tell their bodies by places in this list."""
        return (*self._rigids, *self._softs)

    def body(self, name: str) -> RigidBody | SoftBody:
        """The body of this name. Raises :class:`KeyError`."""
        for body in self.bodies:
            if body.name == name:
                return body
        raise KeyError(f"there is no body `{name}`: there are {', '.join(body.name for body in self.bodies)}")

    @property
    def contacts(self) -> View[np.void]:
        """The contact points of the last step, near and touching, ``(C,)`` records of ``thenar.CONTACT``.

        ``contacts["force"]`` is ``(C, 3)`` [N], on the first body of ``contacts["bodies"]``, ``(C, 2)``; and so on for
        ``vertices``, ``point`` [m], ``normal``, ``slip`` [m/s], ``gap`` [m], ``area`` [m²], ``friction`` and ``slips``.
        Empty after :meth:`reset` and :meth:`set_state`, until the next step.
        """
        return self._views.get("contacts", CONTACT, (-1,))

    @property
    def state_hash(self) -> int:
        """A hash of every bit of the state, as recordings and ``thenar record`` have it."""
        return self._native.state_hash()

    def state(self) -> bytes:
        """Everything that the next steps depend on, besides the scene and what comes from outside.

        Time, bodies, what contact and tissue remember, who moves the hands, and changed settings.
        """
        return self._native.state()

    def set_state(self, state: bytes) -> None:
        """Goes on from a :meth:`state` of this world, or of another of the same scene, with the same bits.

        Raises :class:`thenar.StateError` when the bytes are none of that: of a scene with another text, other overrides
        or another start, or damaged. Nothing has changed then.
        """
        self._native.set_state(state)

    def settings(self) -> list[Setting]:
        """The settings that :meth:`set` may change, as they are now."""
        return [Setting(*row) for row in self._native.settings()]

    def set(self, key: str, value: float | str) -> None:
        """Changes a setting of the running world from the next step on, e.g. ``set("friction", 0.4)``.

        Raises :class:`thenar.SettingError`; nothing has changed then.
        """
        self._native.set(key, value)

    def picture(
        self,
        width: int = 960,
        height: int = 640,
        *,
        layers: str = "skin",
        camera: Camera | None = None,
        quality: Literal["quick", "movie", "still"] = "movie",
    ) -> npt.NDArray[np.uint8]:
        """A picture of the world as it is, ``(height, width, 3)``: sRGB, rows from the top.

        Drawn without a screen by the renderer of ``thenar run --picture``; the same bytes whatever the number of
        threads. Other Python threads run meanwhile. ``layers``: one or more of skin, flesh, bones, tracked, targets,
        contacts, forces, pressure, weights, with commas between. ``camera``: the scene's own, or one that shows
        everything, when left out. ``quality``: ``"still"`` is that of the program's pictures, ``"movie"`` that of its
        movies, ``"quick"`` has no ambient light and coarse shadows, in a fraction of the time.

        Raises :class:`ValueError`: no such layer, a size or a camera that is none.
        """
        size = (operator.index(width), operator.index(height))
        data = self._native.picture(_size(size), layers, _eye(camera), quality)
        return np.frombuffer(data, dtype=np.uint8).reshape(size[1], size[0], 3)

    def save_picture(
        self,
        path: str | os.PathLike[str],
        width: int = 960,
        height: int = 640,
        *,
        layers: str = "skin",
        camera: Camera | None = None,
    ) -> None:
        """Writes a picture as a PNG file, as good as that of ``thenar run --picture`` and with its bytes.

        See :meth:`picture`. Raises :class:`OSError` too, when the file cannot be written.
        """
        size = _size((operator.index(width), operator.index(height)))
        self._native.save_picture(os.fspath(path), size, layers, _eye(camera), "still")

    def record(self, path: str | os.PathLike[str], *, keyframes: float = 1.0) -> Recorder:
        """Records from now on, until :meth:`Recorder.end` or the end of a ``with`` block.

        ``thenar replay`` and :class:`thenar.Recording` make it again to the bit. ``keyframes``: simulated time
        between whole states in the file [s], 0 for none.

        A recording begins where its scene does, so that the world must be as :meth:`Scene.world` made it (or as its
        :meth:`state` of then): :class:`thenar.RecordingError` otherwise. A file that is there is never replaced:
        :class:`FileExistsError`.
        """
        self._native.record(os.fspath(path), keyframes)
        return Recorder(self._native)

    def __repr__(self) -> str:
        return f"<World {self._name}: {len(self._hands)} hands, {len(self.bodies)} bodies>"


