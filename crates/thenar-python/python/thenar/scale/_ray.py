"""Cases on a Ray cluster: as a dataset, and on actors."""

from __future__ import annotations

import collections
import dataclasses
import importlib
from collections.abc import Iterator, Sequence
from typing import Any

from ._cases import Case, Row, Sweep


#: Blocks of a dataset of cases: enough for a thousand cores, few enough that keeping books of them costs nothing.
_BLOCKS = 1000
#: A case that so many processes did not outlive is not tried again.
_DEATHS = 3


def _ray() -> Any:
    try:
        return importlib.import_module("ray")
    except ImportError as error:
        raise ImportError("cases on Ray need the package ray: pip install thenar[ray]") from error


@dataclasses.dataclass(frozen=True)
class _Batch:
    """What a worker does with a batch of cases: numbers and changes in, rows with units out."""

    sweep: Sweep
    columns: list[tuple[str, str, type]]

    def __call__(self, batch: Any) -> Any:
        pyarrow = importlib.import_module("pyarrow")
        kinds = {float: pyarrow.float64(), int: pyarrow.int64(), str: pyarrow.string()}
        named = [("case", "1", int), ("failed", "", str), *self.columns]
        # Of failed cases alone a batch would have other types, and no table of all could be made.
        fields = [pyarrow.field(name, kinds[kind], metadata={"unit": unit}) for name, unit, kind in named]
        numbers, changes = batch["case"].to_pylist(), batch["set"].to_pylist()
        rows = [self._row(number, overrides) for number, overrides in zip(numbers, changes)]
        return pyarrow.Table.from_pylist(rows, schema=pyarrow.schema(fields))

    def _row(self, number: int, overrides: list[str]) -> Row:
        row = self.sweep.run_overrides(number, overrides)
        return _of_columns(row, {name for name, _, _ in self.columns})


def _of_columns(row: Row, names: set[str]) -> Row:
    """The row, or that of a failure where its figures are not those of the other cases."""
    figures = row.keys() - {"case", "failed"}
    if not figures or figures == names:
        return row
    other = sorted(figures ^ names)[0]
    return {"case": row["case"], "failed": f"the case has other probes than the first: `{other}`"}


def ray_dataset(
    sweep: Sweep, cases: Sequence[Case], *, batch_size: int = 1, blocks: int | None = None, **options: Any
) -> Any:
    """A ``ray.data.Dataset`` with a row for each case, from ``map_batches`` over a dataset of cases.

    Nothing is run before its rows are asked for. ``batch_size``: cases that a task runs one after the other, each
    on one core; ``blocks``: how many blocks of cases there are, one for each case and 1000 at most when left out; ``options`` go to
    ``map_batches``. Ray runs tasks of a node that died again on others, and every case is there once. Columns
    carry their units as metadata ``unit`` of Arrow fields. Rows come in no order: sort by ``case``.

    Raises :class:`thenar.SceneError` where no case can be built, :class:`ImportError` without Ray.
    """
    _ray()
    data = importlib.import_module("ray.data")
    items = [{"case": number, "set": sweep.overrides(case)} for number, case in enumerate(cases)]
    work = _Batch(sweep, sweep.columns(cases))
    given = data.from_items(items, override_num_blocks=blocks or min(len(items), _BLOCKS))
    options = {"num_cpus": 1, **options}
    return given.map_batches(work, batch_size=batch_size, batch_format="pyarrow", **options)


class _Actor:
    """A process that keeps the sweep, and what was built for its cases, between them."""

    def __init__(self, sweep: Sweep) -> None:
        self._sweep = sweep

    def ready(self) -> None:
        """Comes back once there is a process."""

    def run(self, number: int, overrides: list[str]) -> Row:
        return self._sweep.run_overrides(number, overrides)


def ray_actors(sweep: Sweep, cases: Sequence[Case], *, actors: int, **options: Any) -> Iterator[Row]:
    """Rows as they come, from so many actors, each on one core; ``options`` go to ``ray.remote``.

    An actor has one case at a time, so long ones keep nobody waiting. The case of an actor that dies, with its node or
    alone, goes to whoever is free, and another actor is asked for; each case comes once. A case of which three
    actors have died has failed. Ends all actors when it ends.

    Raises :class:`ValueError`: ``actors`` is less than 1; :class:`ImportError` without Ray.
    """
    if actors < 1:
        raise ValueError(f"actors: expected 1 or more, got {actors}")
    return _rows(_ray(), sweep, [sweep.overrides(case) for case in cases], actors, {"num_cpus": 1, **options})


def _rows(ray: Any, sweep: Sweep, changes: list[list[str]], actors: int, options: dict[str, Any]) -> Iterator[Row]:
    died = importlib.import_module("ray.exceptions").RayActorError
    actor = ray.remote(**options)(_Actor)
    everyone: list[Any] = []
    idle: list[Any] = []
    left = collections.deque(range(len(changes)))
    deaths: collections.Counter[int] = collections.Counter()
    # What is awaited: a case of an actor, or that there is one. One for which no core is free keeps no case waiting.
    awaited: dict[Any, tuple[Any, int | None]] = {}

    def ask_for_actor() -> None:
        everyone.append(actor.remote(sweep))
        awaited[everyone[-1].ready.remote()] = (everyone[-1], None)

    try:
        for _ in range(min(actors, len(changes))):
            ask_for_actor()
        rows = 0
        while rows < len(changes):
            while idle and left:
                worker, number = idle.pop(), left.popleft()
                awaited[worker.run.remote(number, changes[number])] = (worker, number)
            done, _ = ray.wait(list(awaited), num_returns=1)
            worker, case = awaited.pop(done[0])
            try:
                row: Row | None = ray.get(done[0])
            except died:
                if case is None:
                    # Where none can begin, more would not either.
                    if not awaited and not idle:
                        raise
                    continue
                deaths[case] += 1
                ask_for_actor()
                if deaths[case] < _DEATHS:
                    left.appendleft(case)
                    continue
                row = {"case": case, "failed": f"the processes that ran it died, {_DEATHS} times"}
            else:
                idle.append(worker)
            if row is not None:
                rows += 1
                yield row
    finally:
        for worker in everyone:
            ray.kill(worker)
