"""Many cases of one scene: in this process, on Ray, on Dask, and in arrays of Slurm jobs.

A case is a dict of changes to a scene, as ``set=`` of :class:`thenar.Scene` takes them; its row holds what
``thenar sweep`` writes of it, with the same bits. A case that fails is a row whose ``failed`` says why.

>>> from thenar import scale
>>> cases = scale.grid({"hand.hand.friction": [0.4, 0.8], "time_step": [0.002, 0.005]})
>>> rows = [scale.Sweep("table-press").run(number, case) for number, case in enumerate(cases)]

Ray and Dask are extras: ``pip install thenar[ray]``, ``pip install thenar[dask]``. ``docs/scale.md`` tells more.
"""

from ._cases import Case, Cell, Row, Sweep, grid
from ._dask import dask_bag
from ._ray import ray_actors, ray_dataset
from ._slurm import slurm_script, slurm_shard, slurm_submit

__all__ = [
    "Case",
    "Cell",
    "Row",
    "Sweep",
    "dask_bag",
    "grid",
    "ray_actors",
    "ray_dataset",
    "slurm_script",
    "slurm_shard",
    "slurm_submit",
]
