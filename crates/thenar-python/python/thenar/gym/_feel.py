"""Feeling."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, ClassVar

import gymnasium
import numpy as np
import numpy.typing as npt

from ._env import FRICTION, SQUEEZE_MAX, SQUEEZE_STEP, WRIST_STEP, HandEnv, grip


class Feel(HandEnv):
    """A hand is to press on a block and to say how soft it is.

    Young's modulus of the block is drawn anew for each episode and is hidden; only touch, and pictures, tell of it.

    **Action**, ``(5,)`` from -1 to 1: how the wanted wrist moves (x, y, z, in :data:`WRIST_STEP`), how the wanted
    squeeze changes (in :data:`SQUEEZE_STEP`, from 0 to :data:`SQUEEZE_MAX`; :func:`grip` makes the angles), and the
    estimate: -1 is the lower end of :data:`YOUNG`, 1 the upper, in between by the logarithm
    (:meth:`young` and :meth:`estimate`). Only the last action's estimate counts.

    **Observation**: see :class:`HandEnv`; there is no ``"state"``.

    **Reward**: 0, and in the last step, the :data:`STEPS`th (terminated), minus the relative error of the estimate,
    ``-abs(estimated / true - 1)``. ``info``: ``young`` [Pa], the truth, ``force`` [N] (the sum of normal forces of the
    hand on the block) and ``friction``.

    ``reset(seed=...)`` draws Young's modulus from :data:`YOUNG` (uniform in the logarithm) and friction from
    :data:`FRICTION`. The same seed and actions give the same bits. Where a step is taken back, as a number was not
    finite, the episode is truncated.
    """

    #: Least and largest Young's modulus [Pa]: from fat to a firm foam.
    YOUNG: ClassVar[tuple[float, float]] = (1e4, 1e5)
    #: Steps of an episode: 2.5 s.
    STEPS: ClassVar[int] = 150

    def __init__(
        self,
        *,
        observe: str | Iterable[str] = "proprioception",
        image_size: tuple[int, int] = (96, 64),
        render_mode: str | None = None,
    ) -> None:
        super().__init__("feel", observe=observe, image_size=image_size, render_mode=render_mode, places=0)
        self._squeeze = 0.0
        self._young = 0.0
        self._friction = 0.0
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (5,), np.float64)

    @classmethod
    def young(cls, estimate: float) -> float:
        """Young's modulus [Pa] that the last number of an action stands for."""
        low, high = cls.YOUNG
        return float(low * (high / low) ** ((estimate + 1.0) / 2.0))

    @classmethod
    def estimate(cls, young: float) -> float:
        """The number of an action that stands for this Young's modulus [Pa]."""
        low, high = cls.YOUNG
        return 2.0 * math.log(young / low) / math.log(high / low) - 1.0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begins an episode."""
        self._friction = self._begin(seed, FRICTION)
        self._young = self.young(float(self.np_random.uniform(-1.0, 1.0)))
        self._world.set("object_young", self._young)
        self._angles = grip(0.0)
        self._squeeze = 0.0
        return self._seen(), self._info()

    def step(self, action: npt.ArrayLike) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Makes a step of 1/60 s."""
        wanted = self._checked(action)
        self._squeeze = float(np.clip(self._squeeze + SQUEEZE_STEP * wanted[3], 0.0, SQUEEZE_MAX))
        report = self._go(self._wrist[:3] + WRIST_STEP * wanted[:3], grip(self._squeeze))
        done = self._steps >= self.STEPS
        reward = -abs(self.young(float(wanted[4])) / self._young - 1.0) if done else 0.0
        return self._seen(), reward, done, report.non_finite, self._info()

    def _info(self) -> dict[str, Any]:
        return {"young": self._young, "force": self._squeeze_force(), "friction": self._friction}
