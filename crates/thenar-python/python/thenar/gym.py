"""Gymnasium environments. They need the package ``gymnasium``."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from ._scene import Scene
from ._world import World

Array = npt.NDArray[np.float64]

#: Largest change of the wanted wrist in one step [m]: 0.3 m/s.
WRIST_STEP = 0.005
#: Largest change of a wanted joint angle in one step [rad]: 3 rad/s.
ANGLE_STEP = 0.05
#: The bread is lifted when its centre is so much higher than at the start [m],
LIFTED = 0.05
#: for so many steps in a row: half a second.
HELD = 30
#: Steps of an episode: 4.5 s.
STEPS = 270
#: Coefficients of friction that an episode may have.
FRICTION = (0.6, 1.0)


class Lift(gymnasium.Env[Array, Array]):
    """A hand that is to grasp a small loaf of bread and lift it: the scene ``bread-grasp``, 60 steps a second, with the
    paper's hand of 600 tetrahedra, as learning takes many steps.

    **Action**, ``(23,)`` from -1 to 1: how the wanted wrist moves (x, y, z, in :data:`WRIST_STEP`), and how the twenty
    wanted angles change (order of :attr:`thenar.Hand.angles`, in :data:`ANGLE_STEP`). The wrist keeps its direction.
    The hand follows what is wanted as it follows a tracked hand.

    **Observation**, ``(61,)``: wrist (3) [m], angles (20) [rad], wanted wrist (3) [m], wanted angles (20) [rad], centre
    of the bread (3) [m], and normal and shear force on palm, thumb, index, middle, ring and little finger (12) [N].

    **Reward** of a step: how much higher the bread's centre is than at the start, in :data:`LIFTED`, from 0 to 1.
    An episode ends (terminated) once the bread was lifted for :data:`HELD` steps, with 1 for each step that is left of
    :data:`STEPS`; after these it is cut off (truncated). ``info["height"]`` [m], ``info["friction"]``; ``info["is_success"]``: it was lifted.

    ``reset(seed=...)`` draws the coefficient of friction from :data:`FRICTION`. The same seed and actions give the same
    bits. Where a step is taken back, as a number was not finite, the episode is truncated.
    """

    metadata: dict[str, Any] = {"render_modes": [], "render_fps": 60}

    def __init__(self) -> None:
        self._world: World = Scene.named("bread-grasp", set={"hand.hand.preset": "paper"}).world()
        self._hand = self._world.hands[0]
        self._loaf = next(body for body in self._world.soft_bodies if body.name == "bread")
        self._start = self._world.state()
        ranges = [angle or None for angle in self._hand.angle_ranges]
        self._low = np.array([angle.min if angle else 0.0 for angle in ranges])
        self._high = np.array([angle.max if angle else 0.0 for angle in ranges])
        self._wrist = np.zeros(7)
        self._angles = np.zeros(20)
        self._rest = 0.0
        self._held = 0
        self._steps = 0
        self._friction = 0.0
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (23,), np.float64)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (61,), np.float64)

    @property
    def world(self) -> World:
        """The world, to look into."""
        return self._world

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begins an episode."""
        super().reset(seed=seed)
        self._world.set_state(self._start)
        self._friction = float(self.np_random.uniform(*FRICTION))
        self._world.set("friction", self._friction)
        self._wrist = self._hand.wrist.copy()
        self._angles = np.nan_to_num(self._hand.angles.array)
        self._rest = self._bread()[1]
        self._held = self._steps = 0
        return self._observe(), self._info()

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Makes a step of 1/60 s."""
        wanted = np.clip(np.asarray(action, dtype=np.float64), -1.0, 1.0)
        self._wrist[:3] += WRIST_STEP * wanted[:3]
        self._angles = np.clip(self._angles + ANGLE_STEP * wanted[3:], self._low, self._high)
        self._hand.follow_angles(self._wrist, self._angles)
        report = self._world.step()
        self._steps += 1
        height = self._height()
        self._held = self._held + 1 if height >= LIFTED else 0
        reward = float(np.clip(height / LIFTED, 0.0, 1.0))
        done = self._held >= HELD
        if done:
            # Whoever succeeds soon is not paid less than whoever hovers.
            reward += STEPS - self._steps
        cut = self._steps >= STEPS or report.non_finite
        return self._observe(), reward, done, cut, self._info()

    def _bread(self) -> Array:
        """The centre of the bread's nodes [m]."""
        centre: Array = self._loaf.nodes.array.mean(axis=0)
        return centre

    def _height(self) -> float:
        return float(self._bread()[1] - self._rest)

    def _observe(self) -> Array:
        loads = self._hand.loads
        return np.concatenate(
            [
                self._hand.wrist[:3],
                np.nan_to_num(self._hand.angles.array),
                self._wrist[:3],
                self._angles,
                self._bread(),
                loads["normal"],
                loads["shear"],
            ]
        )

    def _info(self) -> dict[str, Any]:
        return {"height": self._height(), "friction": self._friction, "is_success": self._held >= HELD}
