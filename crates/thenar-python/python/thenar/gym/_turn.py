"""Turning in the hand."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar

import gymnasium
import numpy as np
import numpy.typing as npt

from ._env import ANGLE_STEP, Array, HandEnv, grip


def _matrix(pose: Array) -> Array:
    """Rotation of a pose."""
    x, y, z, w = pose[3:]
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


class Turn(HandEnv):
    """A hand holds a rod across thumb and fingers, above a table, and is to turn it in the hand: about the vertical,
    clockwise as seen from above, without dropping it or pressing on it with more than ``force_limit`` [N] (sum of normal
    forces; the grasp that it begins with has 30 N). The wrist stays where it is.

    **Action**, ``(20,)`` from -1 to 1: how the twenty wanted angles change (order of :attr:`thenar.Hand.angles`, in
    :data:`ANGLE_STEP`).

    **Observation**: see :class:`HandEnv`; of ``"state"``, ``(65,)``, the numbers 46 to 52 are the rod's pose.

    **Reward** of a step: how far the rod was turned in it, in :data:`TURNED`. An episode ends (terminated) with 1 more
    once the rod is turned by :data:`TURNED`, and with 1 less once it has sunk by :data:`DROPPED` or is pressed
    too hard. After :data:`STEPS` it
    is cut off (truncated). ``info``: ``turned`` [rad] (the sum of the steps' turns about the axis), ``height`` [m]
    (against the start), ``force`` [N] (the sum of normal forces of the hand on the rod), ``friction``, ``is_success``.

    ``reset(seed=...)`` draws the coefficient of friction from :data:`FRICTION`. The same seed and actions give the same
    bits. Where a step is taken back, as a number was not finite, the episode is truncated.
    """

    #: The axis of the turn, world.
    AXIS: ClassVar[tuple[float, float, float]] = (0.0, -1.0, 0.0)
    #: Turn that is wanted [rad].
    TURNED: ClassVar[float] = 0.75
    #: The rod is dropped when it is so much lower than at the start [m].
    DROPPED: ClassVar[float] = 0.03
    #: Steps of an episode: 3 s.
    STEPS: ClassVar[int] = 180
    #: Coefficients of friction that an episode may have.
    FRICTION: ClassVar[tuple[float, float]] = (0.8, 1.0)

    def __init__(
        self,
        *,
        observe: str | Iterable[str] = "state",
        force_limit: float = 55.0,
        image_size: tuple[int, int] = (96, 64),
        render_mode: str | None = None,
    ) -> None:
        super().__init__("turn", observe=observe, image_size=image_size, render_mode=render_mode, places=7)
        if not force_limit > 0.0:
            raise ValueError(f"force_limit: expected more than 0 N, got {force_limit}")
        self._limit = float(force_limit)
        self._friction = 0.0
        self._turned = 0.0
        self._rest = 0.0
        self._last: Array = np.eye(3)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (20,), np.float64)
        self._take_up()
        self._start = self._world.state()
        self._held = self._angles.copy()

    def _take_up(self) -> None:
        """Grasps the rod and lifts it: where episodes begin."""
        place, squeeze = self._wrist[:3].copy(), 0.0
        # Down, closed, up; in all 3.6 s.
        for goal, closed, steps in [((0.066, 0.13, 0.07), 0.0, 35), ((0.066, 0.099, 0.07), 0.0, 30),
                                    ((0.066, 0.099, 0.07), 1.0, 60), ((0.066, 0.19, 0.07), 1.0, 90)]:  # fmt: skip
            for _ in range(steps):
                place = place + np.clip(np.array(goal) - place, -0.0018, 0.0018)
                squeeze += float(np.clip(closed - squeeze, -0.04, 0.04))
                self._go(place, grip(squeeze))

    def _place(self) -> Array:
        return self._pose()

    def _pose(self) -> Array:
        pose: Array = self._world.rigid_bodies[self._pair[0]].pose.array
        return pose

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begins an episode."""
        self._friction = self._begin(seed, self.FRICTION)
        self._wrist[:3] = (0.066, 0.19, 0.07)
        self._angles = self._held.copy()
        self._rest = float(self._centre()[1])
        self._last = _matrix(self._pose())
        self._turned = 0.0
        return self._seen(), self._info(False)

    def step(self, action: npt.ArrayLike) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Makes a step of 1/60 s."""
        wanted = self._checked(action)
        report = self._go(self._wrist[:3].copy(), self._angles + ANGLE_STEP * wanted)
        now = _matrix(self._pose())
        change = now @ self._last.T
        # The axial vector of a rotation by a is sin a along its axis; turns of a step are small.
        axial = np.array([change[2, 1] - change[1, 2], change[0, 2] - change[2, 0], change[1, 0] - change[0, 1]]) / 2
        turn = float(axial @ np.array(self.AXIS))
        self._last = now
        self._turned += turn
        reward = turn / self.TURNED
        done = self._turned >= self.TURNED
        lost = self._height() < -self.DROPPED or self._squeeze_force() > self._limit
        done = done and not lost
        reward += float(done) - float(lost)
        cut = self._steps >= self.STEPS or report.non_finite
        return self._seen(), reward, done or lost, cut, self._info(done)

    def _height(self) -> float:
        return float(self._centre()[1] - self._rest)

    def _info(self, success: bool) -> dict[str, Any]:
        return {
            "turned": self._turned,
            "height": self._height(),
            "force": self._squeeze_force(),
            "friction": self._friction,
            "is_success": success,
        }
