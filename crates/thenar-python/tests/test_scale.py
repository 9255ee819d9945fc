"""Goal: cases give the same bits wherever they run, each once, and failures are rows. Method: one grid of a light
scene, run in this process, by the program, on threads of Dask, and by a fake Slurm."""

from __future__ import annotations

import os
import pathlib
import pickle
import stat
import subprocess
import sys

import pytest

import thenar
from thenar import scale

# A drop for 20 steps: light, and different for each mass and force. 1e12 N would move a grain by 1e15 m in a step.
VARY: dict[str, list[thenar.Value]] = {
    "rigid.ball.mass": [1e-9, 0.3],
    "load.0.force": [[0.0, 0.0, 0.0], [0.0, 1e-3, 0.0], [1e12, 0.0, 0.0]],
}
BLOW_UP = [2, 5]
SCENE = """
version = 1
duration = 0.02
time_step = 0.001
[[rigid]]
name = "floor"
shape = { kind = "plane" }
motion = "fixed"
[[rigid]]
name = "ball"
mass = 1
shape = { kind = "sphere", radius = 0.02 }
position = [0, 0.1, 0]
[[load]]
kind = "force"
body = "ball"
force = [0, 0, 0]
[[probe]]
name = "ball"
measure = "pose"
body = "ball"
"""


@pytest.fixture
def sweep(tmp_path: pathlib.Path) -> scale.Sweep:
    """The light scene."""
    file = tmp_path / "drop.toml"
    file.write_text(SCENE)
    return scale.Sweep(file)


def rows_here(sweep: scale.Sweep) -> list[scale.Row]:
    """The rows of all cases, one after the other."""
    return [sweep.run(number, case) for number, case in enumerate(scale.grid(VARY))]


def test_the_last_key_of_a_grid_is_the_fastest() -> None:
    cases = scale.grid({"a": [1, 2], "b": ["x", "y", "z"]})
    assert cases == [{"a": a, "b": b} for a in (1, 2) for b in ("x", "y", "z")]


@pytest.mark.parametrize("vary", [{}, {"a": []}, {"a": "xy"}])
def test_what_is_no_grid_is_refused(vary: dict[str, list[thenar.Value]]) -> None:
    with pytest.raises(ValueError, match="^vary: "):
        scale.grid(vary)


def test_a_row_has_the_bits_of_a_world_and_a_failure_its_reason(sweep: scale.Sweep) -> None:
    rows = rows_here(sweep)
    for case, row in zip(scale.grid(VARY), rows, strict=True):
        world = thenar.Scene.from_file(sweep.scene, set=case).world()
        world.step(20)
        assert row["steps"] == 20 and row["state_hash"] == f"{world.state_hash:016x}"
    assert [row["case"] for row in rows if row["failed"] is not None] == BLOW_UP
    for number in BLOW_UP:
        assert "of 20 steps gave numbers that are not finite" in str(rows[number]["failed"])
    assert rows[BLOW_UP[0]]["non_finite"] == 20
    hashes = {row["state_hash"] for row in rows if row["failed"] is None}
    assert len(hashes) == len(rows) - len(BLOW_UP), "two cases are the same"


def test_a_case_that_cannot_be_built_is_a_row(sweep: scale.Sweep) -> None:
    row = sweep.run(7, {"rigid.ball.mass": -1.0})
    assert set(row) == {"case", "failed"} and row["case"] == 7 and "mass" in str(row["failed"])


def test_a_file_that_is_another_one_fails_the_case(tmp_path: pathlib.Path) -> None:
    def tets(height: float) -> None:
        text = f"nodes = [[0,0,0],[1,0,0],[0,1,0],[0,0,{height}]]\ntets = [[0,1,2,3]]\n"
        (tmp_path / "tets.toml").write_text(text)

    scene = tmp_path / "soft.toml"
    soft = '[[soft]]\nname = "a"\nshape = { kind = "tet-file", file = "tets.toml" }\n'
    scene.write_text(f"version = 1\nduration = 0.01\n{soft}")
    tets(1.0)
    assert thenar.Scene.from_file(scene).files == ["tets.toml"]
    sweep = scale.Sweep(scene)
    assert sweep.run(0, {})["failed"] is None
    # As on a machine that has another file there, or none.
    there = pickle.loads(pickle.dumps(sweep))
    tets(2.0)
    assert "tets.toml is not the file that it was" in str(there.run(1, {})["failed"])
    (tmp_path / "tets.toml").unlink()
    assert "tets.toml is not the file that it was" in str(there.run(1, {})["failed"])
    tets(1.0)
    assert there.run(0, {}) == sweep.run(0, {}) and there.run(0, {})["failed"] is None


def test_what_is_wrong_with_a_sweep_is_told_at_once(sweep: scale.Sweep) -> None:
    with pytest.raises(thenar.SceneError, match="no-such"):
        scale.Sweep("no-such.toml")
    with pytest.raises(ValueError, match="set for all cases and by a case"):
        scale.Sweep(sweep.scene, set={"duration": 1.0}).overrides({"duration": 2.0})
    with pytest.raises(ValueError, match="seconds"):
        scale.Sweep(sweep.scene, seconds=-1.0).run(0, {})
    with pytest.raises(thenar.SceneError, match=r"mass"):
        sweep.columns([{"rigid.ball.mass": -1.0}])


def test_dask_gives_the_same_rows_in_order(sweep: scale.Sweep) -> None:
    pytest.importorskip("dask.bag")
    cases = scale.grid(VARY)
    for npartitions in (None, 1):
        assert scale.dask_bag(sweep, cases, npartitions=npartitions).compute(scheduler="threads") == rows_here(sweep)
    with pytest.raises(ValueError, match="^cases: "):
        scale.dask_bag(sweep, [])


def environment(task: int, first: int, last: int, count: int) -> dict[str, str]:
    """What Slurm tells a task of an array."""
    words = {"ID": task, "MIN": first, "MAX": last, "COUNT": count}
    return {f"SLURM_ARRAY_TASK_{word}": str(number) for word, number in words.items()}


def test_a_task_of_an_array_is_a_shard(monkeypatch: pytest.MonkeyPatch) -> None:
    assert scale.slurm_shard(environment(3, 1, 8, 8)) == (3, 8)
    assert scale.slurm_shard(environment(0, 0, 7, 8)) == (1, 8)
    # `--array=3,7` of an array of eight: nothing says that there were eight.
    for bad in (environment(3, 3, 7, 2), environment(9, 1, 8, 8), {}):
        with pytest.raises(ValueError):
            scale.slurm_shard(bad)
    for name, value in environment(2, 1, 2, 2).items():
        monkeypatch.setenv(name, value)
    assert scale.slurm_shard() == (2, 2)


@pytest.mark.parametrize("words", [{"shards": 0}, {"shards": 2, "threads": 0}, {"shards": 2, "options": ["a\nrm x"]}])
def test_what_makes_no_script_is_refused(words: dict[str, int]) -> None:
    with pytest.raises(ValueError):
        scale.slurm_script(["s.toml"], **words)  # type: ignore[arg-type]


needs_bash = pytest.mark.skipif(sys.platform == "win32", reason="Slurm and its scripts are of Unix")


def fake(folder: pathlib.Path, monkeypatch: pytest.MonkeyPatch, body: str) -> None:
    """Puts an `sbatch` of ours first."""
    program = folder / "bin" / "sbatch"
    program.parent.mkdir()
    program.write_text(body)
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")


@needs_bash
def test_what_sbatch_says_is_told(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake(tmp_path, monkeypatch, "#!/bin/bash\necho 'no such partition' >&2\nexit 1\n")
    with pytest.raises(RuntimeError, match="^sbatch: no such partition$"):
        scale.slurm_submit(scale.slurm_script(["s.toml"], shards=2))


# Runs the tasks that the script's own `--array` names, one after the other, as Slurm would on many machines.
SBATCH = """#!/bin/bash
script=$(mktemp)
cat > "$script"
last=$(sed -n 's/^#SBATCH --array=1-\\([0-9]*\\)$/\\1/p' "$script")
for task in $(seq 1 "$last"); do
  SLURM_ARRAY_TASK_ID=$task bash "$script" >&2
done
echo '4711;cluster'
"""


@needs_bash
def test_an_array_runs_every_case_once_with_the_same_bits(
    sweep: scale.Sweep, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, program: pathlib.Path
) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    fake(tmp_path, monkeypatch, SBATCH)
    (tmp_path / "bin" / "thenar").symlink_to(program)
    out = tmp_path / "results with a blank"
    vary = [f"--vary={key}={','.join(map(str, values))}" for key, values in VARY.items()]
    script = scale.slurm_script([str(sweep.scene), *vary, "--out", str(out), "-q"], shards=2, options=["--time=00:10:00"])
    assert "#SBATCH --time=00:10:00\n" in script
    assert scale.slurm_submit(script) == "4711"
    files = sorted(out.glob("*.parquet"))
    assert len(files) == 2
    rows = sorted((row for file in files for row in parquet.read_table(file).to_pylist()), key=lambda row: row["case"])
    here = rows_here(sweep)
    assert len(rows) == len(here)
    for theirs, ours in zip(rows, here):
        assert all(theirs[name] == value for name, value in ours.items())


@needs_bash
def test_the_script_is_one_that_bash_takes(sweep: scale.Sweep) -> None:
    script = scale.slurm_script(["it's; rm -rf x", "--vary", "a=[1, 2],[3, 4]", "--out", "$HOME"], shards=3)
    done = subprocess.run(["bash", "-n"], input=script, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    assert """'it'"'"'s; rm -rf x' --vary 'a=[1, 2],[3, 4]' --out '$HOME'""" in script
