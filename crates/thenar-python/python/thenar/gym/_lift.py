"""Lifting."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar

import gymnasium
import numpy as np
import numpy.typing as npt

from ._env import ANGLE_STEP, FRICTION, SQUEEZE_MAX, SQUEEZE_STEP, WRIST_STEP, Array, HandEnv, grip

#: What may be lifted, and the sum of normal forces with which the hand may press on it [N]. They make
#: a task: no thing of this kind is known to break there. A grip of squeeze 1 lifts bread (21 N) and egg (13 to 15 N),
#: one of 1.3 the car (28 to 31 N), one of 1.4 the card (7 N); 1.4 is too firm for bread and car, 1.2 for the egg.
FORCE_LIMITS = {"bread": 40.0, "car": 40.0, "card": 20.0, "egg": 30.0}


class Lift(HandEnv):
    """A hand is to grasp a thing that lies on a table and to lift it, without pressing harder than it bears.

    ``object``: ``"bread"`` (a small loaf, soft), ``"car"`` (a toy car of 100 g), ``"card"`` (of plastic, upright on its
    long edge between two rails) or ``"egg"`` (of 58 g, in a trough). ``force_limit`` [N]: that of :data:`FORCE_LIMITS`
    when left out; ``math.inf`` for none.

    **Action** with ``control="angles"``, ``(23,)`` from -1 to 1: how the wanted wrist moves (x, y, z, in
    :data:`WRIST_STEP`), and how the twenty wanted angles change (order of :attr:`thenar.Hand.angles`, in
    :data:`ANGLE_STEP`). With ``control="grip"``, ``(4,)``: the wrist, and how the wanted squeeze changes (in
    :data:`SQUEEZE_STEP`, from 0 to :data:`SQUEEZE_MAX`), from which :func:`grip` makes the angles. The wrist keeps its
    direction. The hand follows what is wanted as it follows a tracked hand.

    **Observation**: see :class:`HandEnv`; of ``"state"``, ``(61,)``, the numbers 46 to 48 are the object's middle [m].

    **Reward** of a step: half of how much higher the object's middle is than at the start, in :data:`LIFTED`, from 0 to
    1, and another half while it is lifted. An episode ends (terminated) once it was lifted for :data:`HELD` steps, with 1 for each step that is left of
    :data:`STEPS`; it ends without that once the hand presses on the object with more than ``force_limit``: the object
    is broken. After :data:`STEPS` it is cut off (truncated). ``info``: ``height`` [m], ``force`` [N] (the sum of normal
    forces of the hand on the object), ``friction``, ``is_success``, ``is_broken``.

    ``reset(seed=...)`` draws the coefficient of friction from :data:`FRICTION`. The same seed and actions give the same
    bits. Where a step is taken back, as a number was not finite, the episode is truncated.
    """

    #: The object is lifted when its middle is so much higher than at the start [m],
    LIFTED: ClassVar[float] = 0.05
    #: for so many steps in a row: half a second.
    HELD: ClassVar[int] = 30
    #: Steps of an episode: 4.5 s.
    STEPS: ClassVar[int] = 270

    def __init__(
        self,
        object: str = "bread",
        *,
        control: str = "angles",
        observe: str | Iterable[str] = "state",
        force_limit: float | None = None,
        image_size: tuple[int, int] = (96, 64),
        render_mode: str | None = None,
    ) -> None:
        if object not in FORCE_LIMITS:
            raise ValueError(f"object: expected one of {', '.join(FORCE_LIMITS)}, got {object!r}")
        if control not in ("angles", "grip"):
            raise ValueError(f'control: expected "angles" or "grip", got {control!r}')
        self._limit = FORCE_LIMITS[object] if force_limit is None else float(force_limit)
        if not self._limit > 0.0:
            raise ValueError(f"force_limit: expected more than 0 N, got {force_limit}")
        super().__init__(
            f"lift-{object}", observe=observe, image_size=image_size, render_mode=render_mode, places=3
        )
        self._by_grip = control == "grip"
        self._squeeze = 0.0
        self._rest = 0.0
        self._held = 0
        self._friction = 0.0
        self._broken = False
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (4 if self._by_grip else 23,), np.float64)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begins an episode."""
        self._friction = self._begin(seed, FRICTION)
        self._angles = grip(0.0) if self._by_grip else np.nan_to_num(self._hand.angles.array)
        self._rest = float(self._centre()[1])
        self._squeeze = 0.0
        self._held = 0
        self._broken = False
        return self._seen(), self._info(0.0)

    def step(self, action: npt.ArrayLike) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Makes a step of 1/60 s."""
        wanted = self._checked(action)
        if self._by_grip:
            self._squeeze = float(np.clip(self._squeeze + SQUEEZE_STEP * wanted[3], 0.0, SQUEEZE_MAX))
            angles: Array = grip(self._squeeze)
        else:
            angles = self._angles + ANGLE_STEP * wanted[3:]
        report = self._go(self._wrist[:3] + WRIST_STEP * wanted[:3], angles)
        force = self._squeeze_force()
        height = self._height()
        self._held = self._held + 1 if height >= self.LIFTED else 0
        self._broken = force > self._limit
        done = self._held >= self.HELD
        # Half for height and half for enough of it: hovering a little below is not as good.
        reward = 0.5 * float(np.clip(height / self.LIFTED, 0.0, 1.0)) + 0.5 * float(height >= self.LIFTED)
        if done and not self._broken:
            # Whoever succeeds soon is not paid less than whoever hovers.
            reward += self.STEPS - self._steps
        cut = self._steps >= self.STEPS or report.non_finite
        return self._seen(), reward, done or self._broken, cut, self._info(force)

    def _height(self) -> float:
        return float(self._centre()[1] - self._rest)

    def _info(self, force: float) -> dict[str, Any]:
        return {
            "height": self._height(),
            "force": force,
            "friction": self._friction,
            "is_success": self._held >= self.HELD and not self._broken,
            "is_broken": self._broken,
        }
