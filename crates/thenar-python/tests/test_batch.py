"""Goal: worlds stepped together have the bits of worlds stepped alone, whatever the number of threads. Method: hashes;
busy worlds; Ctrl-C."""

import runpy
import threading
from collections.abc import Callable

import pytest

import thenar
from conftest import PAPER, ROOT, pressing

FRICTIONS = [0.2, 0.5, 0.8, 1.1, 1.4]


@pytest.fixture(scope="module")
def state() -> bytes:
    """A hand that presses on a table."""
    return pressing().state()


def world(state: bytes, friction: float) -> thenar.World:
    made = thenar.Scene.named("table-press", set=PAPER).world()
    made.set_state(state)
    made.set("friction", friction)
    return made


def worlds(state: bytes) -> list[thenar.World]:
    return [world(state, friction) for friction in FRICTIONS]


@pytest.fixture(scope="module")
def alone(state: bytes) -> list[int]:
    made = worlds(state)
    for world in made:
        world.step(60)
    return [world.state_hash for world in made]


@pytest.mark.parametrize("threads", [1, 2, 3, 16, None])
def test_the_same_bits_as_alone(threads: int | None, state: bytes, alone: list[int]) -> None:
    batch = thenar.Batch(worlds(state), threads=threads)
    begin = batch[0].steps
    for _ in range(10):
        reports = batch.step(5)
    reports = batch.step(10)
    assert [world.state_hash for world in batch] == alone and len(set(alone)) == len(FRICTIONS)
    assert [report.contacts for report in reports] == [len(world.contacts) for world in batch]
    assert batch[0].steps == begin + 60 and len(batch[1:3]) == 2 and len(batch) == 5


def test_a_busy_world_lets_none_step(state: bytes) -> None:
    batch = thenar.Batch(worlds(state))
    begin = batch[0].steps
    stop = threading.Event()

    def keep() -> None:
        while not stop.is_set():
            try:
                batch[4].step(50)
            except thenar.BusyError:
                pass

    thread = threading.Thread(target=keep)
    thread.start()
    refused = 0
    stepped = 0
    while refused == 0:
        try:
            batch.step(1)
            stepped += 1
        except thenar.BusyError:
            refused += 1
    stop.set()
    thread.join()
    # Those that nobody else steps have made the same number of steps, none when it was refused.
    assert {world.steps for world in batch[:4]} == {begin + stepped}


def test_what_makes_no_sense_is_refused() -> None:
    world = thenar.Scene.named("falling-box").world()
    with pytest.raises(ValueError, match="twice"):
        thenar.Batch([world, world])
    with pytest.raises(ValueError, match="1 or more"):
        thenar.Batch([world], threads=0)
    with pytest.raises(ValueError, match="0 or more"):
        thenar.Batch([world]).step(-1)
    assert thenar.Batch([]).step(3) == []
    # The native half looks for itself.
    with pytest.raises(thenar.BusyError):
        thenar._thenar.step_all([world._native, world._native], 1, 2)
    assert world.steps == 0
    world.step()


def test_control_c_stops_all_of_them_between_two_steps(state: bytes, control_c: Callable[[], None]) -> None:
    batch = thenar.Batch(worlds(state)[:3], threads=2)
    begin = batch[0].steps
    control_c()
    with pytest.raises(KeyboardInterrupt):
        batch.step(10**9)
    batch.step(1)
    assert sum(world.steps - begin for world in batch) > 3
    for stopped, friction in zip(batch, FRICTIONS):
        alone = world(state, friction)
        alone.step(stopped.steps - begin)
        assert alone.state_hash == stopped.state_hash


def test_the_example_measures_each_number_of_threads() -> None:
    many_hands = runpy.run_path(str(ROOT / "crates/thenar-python/examples/many_hands.py"))
    rows = many_hands["measure"](hands=2, steps=2, turns=1, threads=[1, 2])
    assert [row.threads for row in rows] == [1, 2]
    assert all(row.steps_per_second > 0.0 and row.processor > 0.0 for row in rows)
