"""Gymnasium environments: a soft hand lifts things, feels how soft they are, and turns them. They need ``gymnasium``.

>>> import gymnasium, thenar.gym
>>> env = gymnasium.make("thenar/Lift-v0", object="egg", observe=["proprioception", "taxels"])
>>> batch = gymnasium.make_vec("thenar/Lift-v0", num_envs=2, vectorization_mode="async")

Ids: ``thenar/Lift-v0``, ``thenar/Feel-v0``, ``thenar/Turn-v0``. ``docs/python.md`` tells of all three.
"""

from __future__ import annotations

import gymnasium

from ._env import (
    ANGLE_STEP,
    CLOSED,
    FRICTION,
    OBSERVATIONS,
    OPEN,
    SQUEEZE_MAX,
    SQUEEZE_STEP,
    WRIST_STEP,
    HandEnv,
    grip,
)
from ._feel import Feel
from ._lift import FORCE_LIMITS, Lift
from ._turn import Turn

__all__ = [
    "ANGLE_STEP",
    "CLOSED",
    "FORCE_LIMITS",
    "FRICTION",
    "OBSERVATIONS",
    "OPEN",
    "SQUEEZE_MAX",
    "SQUEEZE_STEP",
    "WRIST_STEP",
    "Feel",
    "HandEnv",
    "Lift",
    "Turn",
    "grip",
]

for _kind in (Lift, Feel, Turn):
    # Episodes end by themselves.
    gymnasium.register(id=f"thenar/{_kind.__name__}-v0", entry_point=f"thenar.gym:{_kind.__name__}")
