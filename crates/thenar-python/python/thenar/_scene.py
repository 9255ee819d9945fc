"""Scenes."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _thenar
from ._world import World

#: A value of a scene: what TOML knows. Arrays are lists, tuples or arrays of numpy, tables dicts.
Value = (
    bool | int | float | str | list["Value"] | tuple["Value", ...] | dict[str, "Value"] | np.generic | npt.NDArray[Any]
)


def _toml(value: object) -> str:
    """A value as TOML writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # JSON escapes what TOML does, but for DEL.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(v) for v in value) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_toml(str(k))} = {_toml(v)}" for k, v in value.items()) + "}"
    if hasattr(value, "tolist"):
        # A number or an array of numpy.
        return _toml(value.tolist())
    if isinstance(value, (int, float)):
        return repr(value)
    raise TypeError(f"a scene knows no {type(value).__name__}: {value!r}")


def _overrides(changes: Mapping[str, Value] | None) -> list[str]:
    changes = changes or {}
    for key in changes:
        if "=" in key:
            raise _thenar.SceneError(f"override `{key}`: the key has a `=` in it")
    return [f"{key}={_toml(value)}" for key, value in changes.items()]


class Scene:
    """A scene that was read and is sound as a text; :meth:`world` builds its bodies.

    ``set`` changes values of the scene, as ``--set`` of the program does: a dotted key, in which elements of arrays go
    by name or number, and a value: ``{"solver.cone": "linearised", "rigid.table.friction": 0.9}``. ``docs/scene.md``
    lists all keys.
    """

    __slots__ = ("_native",)

    def __init__(self, native: _thenar.Scene) -> None:
        """For the package itself: use :meth:`named`, :meth:`from_file`, :meth:`from_text` or :meth:`from_dict`."""
        self._native = native

    @classmethod
    def named(cls, name: str, *, set: Mapping[str, Value] | None = None) -> Scene:
        """A scene that comes along, see :func:`thenar.scene_names`.

        Raises :class:`thenar.SceneError`: there is none, or a change is wrong.
        """
        return cls(_thenar.Scene.named(name, _overrides(set)))

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], *, set: Mapping[str, Value] | None = None) -> Scene:
        """A scene file.

        Raises :class:`thenar.SceneError`, which says what is wrong and where.
        """
        return cls(_thenar.Scene.from_file(os.fspath(path), _overrides(set)))

    @classmethod
    def from_text(
        cls, text: str, *, file: str | os.PathLike[str] = "scene.toml", set: Mapping[str, Value] | None = None
    ) -> Scene:
        """A scene's text. ``file`` names it in messages; files that the scene names are looked for in its folder.

        Raises :class:`thenar.SceneError`, which says what is wrong and where.
        """
        return cls(_thenar.Scene.from_text(text, os.fspath(file), _overrides(set)))

    @classmethod
    def from_dict(
        cls,
        scene: Mapping[str, Value],
        *,
        file: str | os.PathLike[str] = "scene.toml",
        set: Mapping[str, Value] | None = None,
    ) -> Scene:
        """A scene made by a program: the keys of a scene file, with lists, dicts, numbers, words and arrays of numpy.

        ``{"version": 1, "rigid": [{"name": "ball", "mass": 0.1, "shape": {"kind": "sphere", "radius": 0.02}}]}``;
        :attr:`text` is the file that it stands for. ``file`` is as in :meth:`from_text`.

        Raises :class:`thenar.SceneError`, which says what is wrong, and :class:`TypeError` for what no scene knows.
        """
        text = "".join(f"{_toml(str(key))} = {_toml(value)}\n" for key, value in scene.items())
        return cls.from_text(text, file=file, set=set)

    def world(self) -> World:
        """Builds the bodies; a hand takes half a second the first time. Other Python threads run meanwhile.

        Each call gives another world. Raises :class:`thenar.SceneError`.
        """
        return World(self._native.world())

    @property
    def title(self) -> str | None:
        """A line that says what is to be seen."""
        return self._native.title

    @property
    def description(self) -> str | None:
        """More words."""
        return self._native.description

    @property
    def duration(self) -> float:
        """Simulated time of a run [s]."""
        return self._native.duration

    @property
    def time_step(self) -> float:
        """Time step [s]."""
        return self._native.time_step

    @property
    def text(self) -> str:
        """The scene's text, as it was read."""
        return self._native.text

    @property
    def files(self) -> list[str]:
        """Files that it names, such as meshes, as it calls them; relative paths start at the scene's own folder."""
        return self._native.files

    def __repr__(self) -> str:
        return f"<Scene {self._native.file}: {self.title or 'untitled'}>"


def scene_names() -> list[str]:
    """Names of the scenes that come along."""
    return _thenar.scene_names()
