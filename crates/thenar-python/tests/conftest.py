"""What several tests use."""

from __future__ import annotations

import os
import pathlib

import pytest

import thenar

ROOT = pathlib.Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def program() -> pathlib.Path:
    """The `thenar` program of this tree."""
    path = os.environ.get("THENAR_PROGRAM")
    if path is None:
        pytest.skip("THENAR_PROGRAM names no program")
    return pathlib.Path(path)


def pressing() -> thenar.World:
    """A hand that presses on a table: 40 steps into `table-press`'s script, or where it first bears load."""
    world = thenar.Scene.named("table-press").world()
    while world.step(10).contacts_active == 0:
        assert world.time < 5.0
    world.step(20)
    return world
