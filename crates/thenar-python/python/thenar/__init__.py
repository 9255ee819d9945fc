"""A soft human hand that touches things: scenes, worlds that are stepped, forces per finger and point of skin.

>>> import thenar
>>> world = thenar.Scene.named("bread-grasp").world()
>>> report = world.step(100)
>>> world.hands[0].loads["normal"]  # palm, thumb, index, middle, ring, little [N]

SI units throughout; quaternions are x, y, z, w. ``docs/python.md`` tells all of it.
"""

from ._arrays import CONTACT, LOAD, PARTS
from ._batch import Batch
from ._body import RigidBody, SoftBody
from ._hand import Angle, Grip, Hand, LiveHand
from ._recording import Frame, Recording, Verdict
from ._scene import Scene, Value, scene_names
from ._taxels import LAYOUTS, TAXEL, Patch, Taxels, stack_taxels
from ._thenar import (
    BusyError,
    GripError,
    PoseError,
    RecordingError,
    SceneError,
    SettingError,
    StaleViewError,
    StateError,
    StepReport,
)
from ._view import View
from ._world import Camera, Recorder, Setting, World

__all__ = [
    "CONTACT",
    "LAYOUTS",
    "LOAD",
    "PARTS",
    "TAXEL",
    "Angle",
    "Batch",
    "BusyError",
    "Camera",
    "Frame",
    "Grip",
    "GripError",
    "Hand",
    "LiveHand",
    "Patch",
    "PoseError",
    "Recorder",
    "Recording",
    "RecordingError",
    "RigidBody",
    "Scene",
    "SceneError",
    "Setting",
    "SettingError",
    "SoftBody",
    "StaleViewError",
    "StateError",
    "StepReport",
    "Taxels",
    "Value",
    "Verdict",
    "View",
    "World",
    "scene_names",
    "stack_taxels",
]
