"""Recordings, made again."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from . import _thenar
from ._arrays import CONTACT
from ._body import RigidBody, SoftBody
from ._fields import documented
from ._hand import Hand
from ._view import View, Views
from ._world import bodies_of


@documented
class Frame(NamedTuple):
    """A step of a recording.

    ``time``: time in the recording [s].
    ``scene``: number of its scene, from 1.
    ``step``: steps since the scene's start.
    ``hash``: hash of the state that this step gives here.
    ``same``: whether that is the hash that was recorded; None where none was.
    """

    time: float
    scene: int
    step: int
    hash: int
    same: bool | None


@documented
class Verdict(NamedTuple):
    """Findings of making a recording again.

    ``words``: outcome, in the program's words.
    ``same``: true when all steps that could be compared gave the same bits.
    ``ended``: true when the recording was ended as it should be; known once all of it was made again.
    ``steps``: steps made again.
    ``same_steps``: steps of these that gave the same bits.
    """

    words: str
    same: bool
    ended: bool
    steps: int
    same_steps: int


class Recording:
    """A recording that is made again, step by step: iterate over its frames, and look at bodies and contacts between.

    It is made again by the simulation, not read off: each frame tells whether the bits are those recorded.
    """

    __slots__ = ("_native", "_views", "_scene", "_rigids", "_softs", "_hands")

    def __init__(self, native: _thenar.Recording) -> None:
        """For the package itself: use :meth:`open`."""
        self._native = native
        self._views = Views(native, 0)
        self._scene = 0
        self._rigids: tuple[RigidBody, ...] = ()
        self._softs: tuple[SoftBody, ...] = ()
        self._hands: tuple[Hand, ...] = ()

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> Recording:
        """Opens a recording. Raises :class:`thenar.RecordingError`."""
        return cls(_thenar.Recording.open(os.fspath(path)))

    def __iter__(self) -> Iterator[Frame]:
        while (frame := self.next()) is not None:
            yield frame

    def next(self) -> Frame | None:
        """Makes the next step; None at the end. Raises :class:`thenar.RecordingError`."""
        step = self._native.step()
        if step is None:
            return None
        frame = Frame(*step)
        if frame.scene != self._scene:
            self._begin(frame.scene)
        return frame

    def _begin(self, scene: int) -> None:
        known = json.loads(self._native.describe() or "null")
        self._scene = scene
        self._rigids, self._softs = bodies_of(self._native, known)
        flesh = [hand["soft"] for hand in known["hands"]]
        self._hands = tuple(
            Hand(self._native, i, hand, None if soft is None else self._softs[soft])
            for i, (hand, soft) in enumerate(zip(known["hands"], flesh))
        )

    def verify(self) -> Verdict:
        """Makes all that is left again, and tells whether it gave the same bits."""
        for _ in self:
            pass
        return self.verdict

    @property
    def verdict(self) -> Verdict:
        """The findings so far."""
        return Verdict(*self._native.verdict())

    @property
    def program(self) -> str:
        """The program that recorded it."""
        return self._native.header()[0]

    @property
    def system(self) -> str:
        """Where it was recorded: operating system, processor, vector instructions."""
        _, system, vectors, _ = self._native.header()
        return f"{system}, {vectors}"

    @property
    def hands(self) -> tuple[Hand, ...]:
        """The hands of the present scene; none before the first frame."""
        return self._hands

    @property
    def rigid_bodies(self) -> tuple[RigidBody, ...]:
        """The rigid bodies of the present scene."""
        return self._rigids

    @property
    def soft_bodies(self) -> tuple[SoftBody, ...]:
        """The deformable bodies of the present scene."""
        return self._softs

    @property
    def bodies(self) -> tuple[RigidBody | SoftBody, ...]:
        """The rigid bodies, then the deformable ones: contacts tell their bodies by places in this list."""
        return (*self._rigids, *self._softs)

    @property
    def contacts(self) -> View[np.void]:
        """The contact points of the last step, ``(C,)`` records of ``thenar.CONTACT``, as :attr:`World.contacts`."""
        return self._views.get("contacts", CONTACT, (-1,))

    def __repr__(self) -> str:
        return f"<Recording by {self.program}>"
