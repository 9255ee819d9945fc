"""Goal: what is handed out is whole: wheels have their licences, the sources all that is built in, names their
docstrings; the workflow that makes it names what is there; nothing of it loads a pickle. Method: the installed package's
own list; the archive of sources; the workflow, read as YAML; a pickle that leaves a trace."""

from __future__ import annotations

import ast
import importlib.metadata
import inspect
import pathlib
import pickle
import re
import shutil
import subprocess
import sys
import tarfile
import types
from typing import Any

import pytest

import thenar
import thenar.gym
import thenar.scale
from conftest import ROOT

WORKFLOW = ROOT / ".github/workflows/wheels.yml"
REQUIREMENTS = ROOT / "crates/thenar-python/tests"


def test_the_wheel_has_its_types_and_its_licences() -> None:
    names = {str(file).replace("\\", "/") for file in importlib.metadata.files("thenar") or []}
    assert {"thenar/py.typed", "thenar/_thenar.pyi", "thenar/gym/scenes/turn.toml"} <= names
    licences = {name.partition("/licenses/")[2] for name in names}
    assert {"LICENSE-MIT", "LICENSE-APACHE", "NOTICE", "crates/thenar-rig/assets/hands/LICENSE.md"} <= licences
    about = importlib.metadata.metadata("thenar")
    assert about["License-Expression"] == "MIT OR Apache-2.0" and about["Requires-Python"] == ">=3.10"


def test_the_sources_have_all_that_is_built_into_the_package(tmp_path: pathlib.Path) -> None:
    maturin = shutil.which("maturin", path=str(pathlib.Path(sys.executable).parent))
    if maturin is None:
        pytest.skip("there is no maturin")
    subprocess.run([maturin, "sdist", "--out", str(tmp_path)], check=True, capture_output=True, cwd=ROOT)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as sources:
        sources.extractall(tmp_path, filter="data")
    top = archive.name.removesuffix(".tar.gz")
    built_in = 0
    for file in (tmp_path / top / "crates").rglob("src/**/*.rs"):
        text = file.read_text(encoding="utf-8")
        for name in re.findall(r'include_(?:str|bytes)!\("([^"]+)"\)', text):
            assert (file.parent / name).is_file(), f"{file} wants {name}"
            built_in += 1
    assert built_in >= 2
    folder = "crates/thenar-scene/scenes"
    scenes = {path.name for path in (ROOT / folder).glob("*.toml")}
    assert scenes and {path.name for path in (tmp_path / top / folder).glob("*.toml")} == scenes
    # The lock file goes along, so that the same versions are built, and pip gets past what it does first.
    assert (tmp_path / top / "Cargo.lock").read_bytes() == (ROOT / "Cargo.lock").read_bytes()
    first = [maturin, "pep517", "write-dist-info", "--interpreter", sys.executable, "--metadata-directory", str(tmp_path)]
    done = subprocess.run(first, cwd=tmp_path / top, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    manifest = (tmp_path / top / "Cargo.toml").read_text(encoding="utf-8")
    (members,) = re.findall(r"^members = \[(.*)\]$", manifest, re.M)
    assert "crates/thenar-python" in members and "crates/thenar-serve" not in members


@pytest.mark.parametrize("module", [thenar, thenar.gym, thenar.scale])
def test_help_tells_of_every_public_name(module: types.ModuleType) -> None:
    assert module.__doc__ and len(module.__all__) > 5
    told = 0
    for name in module.__all__:
        thing = getattr(module, name)
        if not (inspect.isclass(thing) or inspect.isfunction(thing)):
            continue
        members = [(name, thing)]
        if inspect.isclass(thing):
            members += [(f"{name}.{key}", value) for key, value in vars(thing).items() if not key.startswith("_")]
        for full, member in members:
            if isinstance(member, (classmethod, staticmethod)):
                member = member.__func__
            if callable(member) or inspect.isdatadescriptor(member):
                words = inspect.getdoc(member) or ""
                assert len(words.split()) > 1 and not words.startswith("Alias for field"), f"{full}: {words!r}"
                told += 1
    assert told > 5


class Evil:
    """Whoever loads its pickle writes a file."""

    def __init__(self, trace: pathlib.Path) -> None:
        self.trace = trace

    def __reduce__(self) -> tuple[Any, ...]:
        return (pathlib.Path.touch, (self.trace,))


def test_no_pickle_is_loaded_and_worlds_are_not_pickled(tmp_path: pathlib.Path) -> None:
    trace, file = tmp_path / "trace", tmp_path / "evil"
    data = pickle.dumps(Evil(trace))
    file.write_bytes(data)
    world = thenar.Scene.named("falling-box").world()
    with pytest.raises(thenar.StateError):
        world.set_state(data)
    with pytest.raises(thenar.RecordingError):
        thenar.Recording.open(file)
    with pytest.raises(thenar.SceneError):
        thenar.Scene.from_file(file)
    assert not trace.exists()
    pickle.loads(data)
    assert trace.exists(), "the pickle does what it is for"
    for thing in (world, world.rigid_bodies[0], world.contacts, thenar.Batch([world]), thenar.Scene.named("pinch")):
        with pytest.raises(TypeError, match="pickle"):
            pickle.dumps(thing)
    # Nor does any module of ours import what loads one.
    package = ROOT / "crates/thenar-python/python/thenar"
    modules = list(package.rglob("*.py"))
    assert len(modules) > 15
    for module in modules:
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, (ast.Import, ast.ImportFrom)) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            loaders = {"pickle", "marshal", "shelve", "dill", "joblib", "cloudpickle"}
            assert not loaders & {name.partition(".")[0] for name in names}, module
            assert not (isinstance(node, ast.keyword) and node.arg == "allow_pickle"), module


@pytest.fixture(scope="module")
def workflow() -> dict[Any, Any]:
    """The workflow of wheels."""
    yaml = pytest.importorskip("yaml")
    read: dict[Any, Any] = yaml.safe_load(WORKFLOW.read_text(encoding="utf-8"))
    return read


def steps(job: dict[str, Any], key: str) -> list[Any]:
    """What the job's steps say of a key."""
    return [step[key] for step in job["steps"] if key in step]


def test_wheels_are_built_for_the_platforms_that_are_promised_and_each_is_tried(workflow: dict[Any, Any]) -> None:
    jobs = workflow["jobs"]
    built = {row["target"]: row["runner"] for row in jobs["wheel"]["strategy"]["matrix"]["include"]}
    assert set(built) == {
        f"{machine}-{system}"
        for system, machines in {
            "unknown-linux-gnu": ["x86_64", "aarch64"],
            "apple-darwin": ["x86_64", "aarch64"],
            "pc-windows-msvc": ["x86_64"],
        }.items()
        for machine in machines
    }
    matrix = jobs["test"]["strategy"]["matrix"]
    assert set(matrix["target"]) == set(built)
    assert {row["target"]: row["runner"] for row in matrix["include"] if "target" in row} == built
    # Both majors of numpy; the interpreters are as old and as new as is promised.
    pythons = {row["requirements"]: row["python"] for row in matrix["include"] if "python" in row}
    assert set(pythons) == set(matrix["requirements"]) and pythons["requirements-oldest.txt"] == "3.10"
    majors = {re.findall(r"numpy==(\d)", (REQUIREMENTS / name).read_text())[0] for name in matrix["requirements"]}
    assert majors == {"1", "2"}
    said = "\n".join(steps(jobs["test"], "run"))
    assert "python -m pytest" in said and "--find-links dist thenar" in said


def test_the_workflow_names_what_is_there(workflow: dict[Any, Any], tmp_path: pathlib.Path) -> None:
    text = WORKFLOW.read_text(encoding="utf-8")
    named = re.findall(r"\b(?:crates|\.github)/[\w./-]+\.\w+", text) + ["rust-toolchain.toml", "pyproject.toml"]
    assert len(named) > 4
    for name in named:
        assert (ROOT / name).exists(), name
    for job in workflow["jobs"].values():
        assert set(job.get("needs", [])) <= set(workflow["jobs"]) or job["needs"] in workflow["jobs"]
    # The maturin that is tried here.
    (maturin,) = set(re.findall(r"maturin-version: v([\d.]+)", text))
    assert f"maturin=={maturin}\n" in (REQUIREMENTS / "requirements.txt").read_text()
    # What an artefact is called where it is written is what it is called where it is read.
    kept = [given["name"] for job in workflow["jobs"].values() for given in steps(job, "with") if "name" in given]
    assert kept.count("wheel-${{ matrix.target }}") == 2 and kept.count("sdist") == 1
    if sys.platform != "win32":
        for job in workflow["jobs"].values():
            for script in steps(job, "run"):
                done = subprocess.run(["bash", "-n"], input=script, text=True, capture_output=True, check=False)
                assert done.returncode == 0, f"{script}: {done.stderr}"


def test_the_toolchain_of_the_sources_is_read_as_the_workflow_reads_it(workflow: dict[Any, Any]) -> None:
    (script,) = [run for run in steps(workflow["jobs"]["sdist"], "run") if "RUSTUP_TOOLCHAIN" in run]
    if sys.platform == "win32":
        pytest.skip("the workflow reads it on Linux")
    first = script.splitlines()[0] + '; echo "$RUSTUP_TOOLCHAIN"'
    done = subprocess.run(["bash", "-ec", first], text=True, capture_output=True, check=True, cwd=ROOT)
    assert re.fullmatch(r"\d+\.\d+\.\d+\n", done.stdout)


def test_only_tags_and_hands_publish_and_no_secret_is_kept(workflow: dict[Any, Any]) -> None:
    assert "secrets." not in WORKFLOW.read_text(encoding="utf-8")
    # YAML takes the word `on` for true.
    events = workflow[True]
    assert set(events) == {"workflow_dispatch", "push", "pull_request"} and set(events["push"]) == {"tags"}
    assert events["workflow_dispatch"]["inputs"]["publish"]["default"] is False
    publish = workflow["jobs"]["publish"]
    assert publish["if"] == "github.ref_type == 'tag' || inputs.publish == true"
    assert set(publish["needs"]) == set(workflow["jobs"]) - {"publish"}
    assert publish["permissions"] == {"id-token": "write"} and workflow["permissions"] == {"contents": "read"}
    assert not any("permissions" in job for name, job in workflow["jobs"].items() if name != "publish")
