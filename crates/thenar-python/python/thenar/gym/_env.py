"""The common part of the environments: a hand that is told where to go, and what is seen of it."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import resources
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from .._body import RigidBody, SoftBody
from .._hand import LiveHand
from .._scene import Scene
from .._thenar import StepReport
from .._world import World

Array = npt.NDArray[np.float64]

#: Largest change of the wanted wrist in one step [m]: 0.3 m/s.
WRIST_STEP = 0.005
#: Largest change of a wanted joint angle in one step [rad]: 3 rad/s.
ANGLE_STEP = 0.05
#: Largest change of the wanted squeeze in one step: from open to closed in a third of a second.
SQUEEZE_STEP = 0.05
#: Largest squeeze: fingers are wanted as far beyond closed as closed is from open.
SQUEEZE_MAX = 2.0
#: Coefficients of friction that an episode may have.
FRICTION = (0.6, 1.0)
#: What may be observed.
OBSERVATIONS = ("state", "proprioception", "taxels", "image")
#: Rows and columns of taxels on each of the five fingertips.
TAXELS = (4, 4)


def _degrees(thumb: list[float], *fingers: list[float]) -> Array:
    """Twenty angles: base flexion and spread, then two flexions, of each finger [rad]."""
    angles: Array = np.radians(np.array([thumb, *fingers], dtype=np.float64).ravel())
    angles.flags.writeable = False
    return angles


#: The twenty angles of a hand that is open around a thing as wide as a small loaf, thumb across from the fingers, and of
#: one that is closed on it [rad], as :attr:`thenar.Hand.angles`.
OPEN = _degrees([-14, 22, 2, 2], [38, 0, 12, 8], [40, 0, 12, 8], [40, 0, 12, 8], [36, 0, 12, 8])
CLOSED = _degrees([14, 22, 14, 18], [58, 0, 18, 10], [66, 0, 18, 12], [66, 0, 20, 12], [60, 0, 20, 12])


def grip(squeeze: float) -> Array:
    """The twenty angles of a grip [rad]: 0 is :data:`OPEN`, 1 :data:`CLOSED`; beyond, the fingers press harder."""
    angles: Array = OPEN + squeeze * (CLOSED - OPEN)
    return angles


class HandEnv(gymnasium.Env[Any, Array]):
    """A scene with a hand and a body ``object``, 60 steps a second, with the paper's hand of 600 tetrahedra, as learning
    takes many steps. See :class:`Lift`, :class:`Feel` and :class:`Turn`.

    ``observe``: one of :data:`OBSERVATIONS`, which is then the observation, or several, which are then a dict of them:

    - ``"proprioception"``: wrist (3) [m], angles (20) [rad], wanted wrist (3) [m], wanted angles (20) [rad], and normal
      and shear force on palm, thumb, index, middle, ring and little finger (12) [N];
    - ``"state"``: the same, and the object's place before the forces;
    - ``"taxels"``, ``(80, 3)``: normal force and two shears of 4 x 4 taxels on each fingertip [N];
    - ``"image"``, ``(height, width, 3)``: what the scene's camera sees, sRGB; ``image_size`` is (width, height).

    ``render_mode``: None, or ``"rgb_array"`` for pictures of 480 x 320.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 60}

    def __init__(
        self,
        scene: str,
        *,
        observe: str | Iterable[str],
        image_size: tuple[int, int],
        render_mode: str | None,
        places: int,
    ) -> None:
        """For the environments themselves. ``places``: numbers of the object's place, 0 if it is hidden."""
        wanted = (observe,) if isinstance(observe, str) else tuple(observe)
        known = OBSERVATIONS if places else OBSERVATIONS[1:]
        for kind in wanted:
            if kind not in known:
                raise ValueError(f"observe: expected some of {', '.join(known)}, got {kind!r}")
        if not wanted or len(set(wanted)) < len(wanted):
            raise ValueError("observe: expected one or more, each once")
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f'render_mode: expected None or "rgb_array", got {render_mode!r}')
        self.render_mode = render_mode
        text = resources.files("thenar.gym").joinpath(f"scenes/{scene}.toml").read_text(encoding="utf-8")
        self._world: World = Scene.from_text(text, file=f"{scene}.toml").world()
        self._hand: LiveHand = self._world.hands[0]
        self._object: RigidBody | SoftBody = self._world.body("object")
        names = [body.name for body in self._world.bodies]
        self._pair = (names.index("object"), names.index(self._hand.name))
        self._taxels = self._hand.taxels("fingertips", rows=TAXELS[0], columns=TAXELS[1])
        self._image_size = image_size
        ranges = self._hand.angle_ranges
        self._low = np.array([angle.min if angle else 0.0 for angle in ranges])
        self._high = np.array([angle.max if angle else 0.0 for angle in ranges])
        self._wrist: Array = self._hand.wrist.copy()
        self._angles: Array = np.nan_to_num(self._hand.angles.array)
        self._start = self._world.state()
        self._steps = 0
        self._single = isinstance(observe, str)
        self._observe = wanted
        spaces: dict[str, gymnasium.Space[Any]] = {
            "state": gymnasium.spaces.Box(-np.inf, np.inf, (58 + places,), np.float64),
            "proprioception": gymnasium.spaces.Box(-np.inf, np.inf, (58,), np.float64),
            "taxels": gymnasium.spaces.Box(-np.inf, np.inf, (len(self._taxels), 3), np.float64),
            "image": gymnasium.spaces.Box(0, 255, (image_size[1], image_size[0], 3), np.uint8),
        }
        self.observation_space = (
            spaces[wanted[0]] if self._single else gymnasium.spaces.Dict({kind: spaces[kind] for kind in wanted})
        )

    @property
    def world(self) -> World:
        """The world, to look into."""
        return self._world

    def render(self) -> Any:
        """A picture, ``(320, 480, 3)``; None without a render mode."""
        return self._world.picture(480, 320) if self.render_mode == "rgb_array" else None

    def _begin(self, seed: int | None, friction: tuple[float, float]) -> float:
        """Puts everything back to the start and draws the coefficient of friction, which is returned."""
        super().reset(seed=seed)
        self._world.set_state(self._start)
        drawn = float(self.np_random.uniform(*friction))
        self._world.set("friction", drawn)
        self._wrist = self._hand.wrist.copy()
        self._steps = 0
        return drawn

    def _go(self, wrist: Array, angles: Array) -> StepReport:
        """Makes a step of 1/60 s with the hand wanted there."""
        self._wrist[:3] = wrist
        self._angles = np.clip(angles, self._low, self._high)
        self._hand.follow_angles(self._wrist, self._angles)
        self._steps += 1
        return self._world.step()

    def _checked(self, action: npt.ArrayLike) -> Array:
        """An action of the right shape, with numbers from -1 to 1; others are brought there."""
        wanted = np.asarray(action, dtype=np.float64)
        if wanted.shape != self.action_space.shape:
            raise ValueError(f"action: expected an array of shape {self.action_space.shape}, got {wanted.shape}")
        if np.isnan(wanted).any():
            raise ValueError("action: a number is not a number")
        return np.clip(wanted, -1.0, 1.0)

    def _centre(self) -> Array:
        """The object's middle: its centre of mass, or the mean of its nodes [m]."""
        if isinstance(self._object, SoftBody):
            centre: Array = self._object.nodes.array.mean(axis=0)
            return centre
        return self._object.pose.array[:3]

    def _place(self) -> Array:
        """The part of ``"state"`` that tells of the object."""
        return self._centre()

    def _squeeze_force(self) -> float:
        """Sum of the normal forces that the hand presses on the object with [N]."""
        contacts = self._world.contacts.array
        ours = np.isin(contacts["bodies"], self._pair).all(axis=1)
        return float(np.abs(np.einsum("ij,ij->i", contacts["force"][ours], contacts["normal"][ours])).sum())

    def _see(self, kind: str) -> npt.NDArray[Any]:
        if kind == "image":
            return self._world.picture(*self._image_size, quality="quick")
        if kind == "taxels":
            felt = self._taxels.read()
            return np.column_stack([felt["normal"], felt["shear"]])
        loads = self._hand.loads
        return np.concatenate(
            [
                self._hand.wrist[:3],
                np.nan_to_num(self._hand.angles.array),
                self._wrist[:3],
                self._angles,
                *([self._place()] if kind == "state" else []),
                loads["normal"],
                loads["shear"],
            ]
        )

    def _seen(self) -> Any:
        """The observation."""
        if self._single:
            return self._see(self._observe[0])
        return {kind: self._see(kind) for kind in self._observe}
