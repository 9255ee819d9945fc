"""Fixtures and worlds of several tests."""

from __future__ import annotations

import os
import pathlib
import signal
import threading
from collections.abc import Callable, Iterator

import pytest

import thenar

ROOT = pathlib.Path(__file__).resolve().parents[3]

# The hand of fewest tetrahedra, for whatever is not about flesh.
PAPER = {"hand.0.preset": "paper"}


@pytest.fixture(scope="session")
def program() -> pathlib.Path:
    """The `thenar` program of this tree."""
    path = os.environ.get("THENAR_PROGRAM")
    if path is None:
        pytest.skip("THENAR_PROGRAM names no program")
    return pathlib.Path(path)


@pytest.fixture
def control_c() -> Iterator[Callable[[], None]]:
    """Presses Ctrl-C 0.3 s after it is called, also where tests run in the background, which ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.3, signal.raise_signal, (signal.SIGINT,))
    yield timer.start
    timer.join()
    signal.signal(signal.SIGINT, before)


def pressing() -> thenar.World:
    """A hand that presses on a table, 20 steps and more after it first bears load."""
    world = thenar.Scene.named("table-press", set=PAPER).world()
    while world.step(10).contacts_active == 0:
        assert world.time < 5.0
    world.step(20)
    return world
