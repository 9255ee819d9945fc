"""Cases, and the row that each of them gives."""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
import operator
import os
from collections.abc import Mapping, Sequence

from .. import _thenar
from .._scene import Scene, Value, _overrides, scene_names

#: Changes to a scene: dotted keys and values.
Case = Mapping[str, Value]
#: A number, a count, a word; None where a case that failed has none.
Cell = float | int | str | None
#: ``case``: its number; ``failed``: why it has no figures or bad ones, or None; then the figures.
Row = dict[str, Cell]


def _sha256(path: str) -> str | None:
    """Of what is in a file; None where it cannot be read."""
    try:
        with open(path, "rb") as file:
            return hashlib.sha256(file.read()).hexdigest()
    except OSError:
        return None


def _title(name: str, unit: str) -> str:
    """A column's name, as `thenar sweep` has it: with its unit, if it has one."""
    return name if unit in ("", "1") else f"{name} [{unit}]"


def grid(vary: Mapping[str, Sequence[Value]]) -> list[dict[str, Value]]:
    """Every combination of these values, the last key fastest: the order in which ``thenar sweep`` numbers cases.

    Raises :class:`ValueError`: nothing is varied, or a key has no value.
    """
    if not vary:
        raise ValueError("vary: expected one key or more")
    for key, values in vary.items():
        if isinstance(values, (str, bytes)):
            raise ValueError(f"vary: {key!r}: expected a list of values, got {values!r}")
        if len(values) == 0:
            raise ValueError(f"vary: {key!r} has no value")
    return [dict(zip(vary, values)) for values in itertools.product(*vary.values())]


@dataclasses.dataclass(frozen=True)
class Sweep:
    """A scene of which cases are run: the name of one that comes along, or a file; ``set`` changes it for all cases.

    ``seconds``: simulated time of a case [s]; the scene's own when left out. Other machines get the scene's text;
    files that it names, such as meshes, must be there under the same paths, and be the same: a case that finds another
    one fails.
    """

    scene: str | os.PathLike[str]
    set: Case = dataclasses.field(default_factory=dict)
    seconds: float | None = None
    _text: str = dataclasses.field(init=False, repr=False)
    _file: str = dataclasses.field(init=False, repr=False)
    _hashes: dict[str, str | None] = dataclasses.field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Reads the scene, so that what is wrong with it is told before anything is run."""
        known = isinstance(self.scene, str) and self.scene in scene_names()
        scene = Scene.named(str(self.scene), set=self.set) if known else Scene.from_file(self.scene, set=self.set)
        object.__setattr__(self, "_text", scene.text)
        object.__setattr__(self, "_file", scene._native.file if known else os.path.abspath(self.scene))
        object.__setattr__(self, "_hashes", {name: _sha256(self._path(name)) for name in scene.files})

    def overrides(self, case: Case) -> list[str]:
        """The changes of a case as ``--set`` takes them."""
        twice = [key for key in case if key in self.set]
        if twice:
            raise ValueError(f"{twice[0]!r} is set for all cases and by a case")
        return _overrides(self.set) + _overrides(case)

    def run(self, number: int, case: Case) -> Row:
        """Runs a case. Other Python threads run meanwhile."""
        return self.run_overrides(number, self.overrides(case))

    def run_overrides(self, number: int, overrides: list[str]) -> Row:
        """Runs a case of which the changes were written by :meth:`overrides`."""
        row: Row = {"case": operator.index(number), "failed": None}
        try:
            scene = self._native(overrides)
            for name in scene.files:
                if name in self._hashes and _sha256(self._path(name)) != self._hashes[name]:
                    return {**row, "failed": f"{self._path(name)} is not the file that it was when the sweep was made"}
            failed, cells = _thenar.run_case(scene, self.seconds)
        except _thenar.SceneError as error:
            return {**row, "failed": str(error)}
        return {**row, "failed": failed, **{_title(name, unit): value for name, unit, value in cells}}

    def columns(self, cases: Sequence[Case]) -> list[tuple[str, str, type]]:
        """Names, units and types of a row's figures, from the first case of which the bodies can be built.

        Raises :class:`thenar.SceneError` of the first case, where none can.
        """
        first: _thenar.SceneError | None = None
        for case in cases:
            try:
                cells = _thenar.case_columns(self._native(self.overrides(case)))
            except _thenar.SceneError as error:
                first = first or error
                continue
            return [(_title(name, unit), unit, type(value)) for name, unit, value in cells]
        raise first or ValueError("cases: expected one or more")

    def _path(self, name: str) -> str:
        return os.path.join(os.path.dirname(self._file), name)

    def _native(self, overrides: list[str]) -> _thenar.Scene:
        return _thenar.Scene.from_text(self._text, self._file, overrides)
