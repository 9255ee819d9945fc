"""Goal: a Ray cluster of two nodes that loses one in the middle gives every case once, with the bits of this process.
Method: a real cluster of two raylets on this machine, one of which is ended without a word."""

from __future__ import annotations

import time
import types
from collections.abc import Iterator
from typing import Any

import pytest

from thenar import scale

ray = pytest.importorskip("ray")
cluster_utils = pytest.importorskip("ray.cluster_utils")

pytestmark = pytest.mark.filterwarnings("ignore")

# Presses with the paper's hand: 0.1 to 1 s each. The last value is no coefficient.
CASES = scale.grid({"hand.0.friction": [0.2, 0.4, 0.6, 0.8, 1.0, -1.0], "time_step": [0.004, 0.005]})


@pytest.fixture(scope="module")
def sweep() -> scale.Sweep:
    """A press of the paper's hand."""
    return scale.Sweep("table-press", set={"hand.0.preset": "paper"}, seconds=0.5)


@pytest.fixture(scope="module")
def expected(sweep: scale.Sweep) -> list[scale.Row]:
    """All rows, as this process makes them."""
    rows = [sweep.run(number, case) for number, case in enumerate(CASES)]
    assert [row["failed"] is None for row in rows] == [case["hand.0.friction"] != -1.0 for case in CASES]
    return rows


@pytest.fixture
def cluster() -> Iterator[tuple[Any, Any]]:
    """Two nodes of one core each: the cluster, and the node without the driver."""
    made = cluster_utils.Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    try:
        node = made.add_node(num_cpus=1)
        ray.init(address=made.address, log_to_driver=False)
        made.wait_for_nodes()
        yield made, node
    finally:
        ray.shutdown()
        made.shutdown()


def same(rows: list[scale.Row], expected: list[scale.Row]) -> None:
    """The same cases, each once, in any order."""
    rows = sorted(rows, key=lambda row: int(row["case"] or 0))
    assert [row["case"] for row in rows] == list(range(len(expected)))
    for row, other in zip(rows, expected):
        # A table has empty cells where a failed case has none.
        assert {name: value for name, value in row.items() if value is not None or name in other} == other


def alive() -> int:
    """Nodes that live."""
    return sum(bool(node["Alive"]) for node in ray.nodes())


def test_a_cluster_that_loses_a_node_gives_every_case_once(
    cluster: tuple[Any, Any], sweep: scale.Sweep, expected: list[scale.Row]
) -> None:
    made, node = cluster
    assert alive() == 2
    # Actors on both nodes; one node dies once some rows are there.
    rows = scale.ray_actors(sweep, CASES, actors=2)
    some = [next(rows), next(rows)]
    made.remove_node(node, allow_graceful=False)
    same([*some, *rows], expected)
    # Ray takes some seconds to be sure that it is dead.
    deadline = time.monotonic() + 60.0
    while alive() > 1:
        assert time.monotonic() < deadline
        time.sleep(0.1)

    # The same of a dataset, on a node that takes the dead one's place.
    node = made.add_node(num_cpus=1)
    made.wait_for_nodes()
    dataset = scale.ray_dataset(sweep, CASES)
    batches = iter(dataset.iter_batches(batch_size=1, batch_format="pyarrow", prefetch_batches=0))
    tables = [next(batches)]
    made.remove_node(node, allow_graceful=False)
    tables.extend(batches)
    same([row for table in tables for row in table.to_pylist()], expected)
    units = {field.name: field.metadata[b"unit"] for field in tables[0].schema}
    assert units["max_penetration [m]"] == b"m" and units["steps"] == b"1"


def test_what_is_wrong_is_told_before_a_cluster_is_asked(sweep: scale.Sweep) -> None:
    with pytest.raises(ValueError, match="^actors: "):
        scale.ray_actors(sweep, CASES, actors=0)
    with pytest.raises(ValueError, match="friction"):
        scale.ray_dataset(sweep, CASES[-1:])


def test_a_worker_makes_a_failure_of_other_columns() -> None:
    row: scale.Row = {"case": 3, "failed": None, "a": 1.0, "c": 2.0}
    from thenar.scale._ray import _of_columns

    assert _of_columns(row, {"a", "c"}) == row
    assert _of_columns(row, {"a", "b"}) == {
        "case": 3,
        "failed": "the case has other probes than the first: `b`",
    }


class Actors:
    """Stands in for Ray: actors that answer at once, and die of cases as often as they are told."""

    def __init__(self, deaths: dict[int, int]) -> None:
        self.deaths, self.asked_for, self.killed = deaths, 0, 0

    def remote(self, *given: Any, **options: Any) -> Any:
        """The decorator, an actor, and a call of one: each has a method of this name."""
        return (lambda _: self) if options else self._begin() if isinstance(given[0], scale.Sweep) else given

    def _begin(self) -> Any:
        self.asked_for += 1
        call = types.SimpleNamespace(remote=lambda *case: (object(), *case[:1]))
        return types.SimpleNamespace(ready=call, run=call)

    def wait(self, awaited: list[Any], num_returns: int) -> tuple[list[Any], list[Any]]:
        """The one that was asked last."""
        return awaited[-num_returns:], awaited[:-num_returns]

    def get(self, call: Any) -> scale.Row | None:
        """What the call gives."""
        _, *case = call
        if case and self.deaths.get(case[0], 0) > 0:
            self.deaths[case[0]] -= 1
            raise ray.exceptions.RayActorError()
        return {"case": case[0], "failed": None} if case else None

    def kill(self, _: Any) -> None:
        """Ends an actor."""
        self.killed += 1


def test_a_case_that_kills_its_processes_fails_and_the_others_do_not(sweep: scale.Sweep) -> None:
    from thenar.scale._ray import _rows

    # Case 1 kills everyone, case 2 only whoever has it first and second.
    actors = Actors({1: 99, 2: 2})
    rows = sorted(_rows(actors, sweep, [[] for _ in range(4)], 2, {"num_cpus": 1}), key=lambda row: int(row["case"] or 0))
    assert [row["case"] for row in rows] == [0, 1, 2, 3]
    assert [row["failed"] for row in rows] == [None, "the processes that ran it died, 3 times", None, None]
    # Two, and one for each death; all are ended.
    assert actors.asked_for == actors.killed == 2 + 3 + 2
