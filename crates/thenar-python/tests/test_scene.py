"""Goal: scenes are read as the program reads them, and refused in its words. Method: shipped scenes and wrong ones."""

import pathlib
import subprocess
from collections.abc import Callable

import numpy as np
import pytest

import thenar
from conftest import ROOT

SCENES = ROOT / "crates/thenar-scene/scenes"


def test_the_scenes_that_come_along_are_those_of_the_tree() -> None:
    files = {path.stem for path in SCENES.glob("*.toml")}
    assert set(thenar.scene_names()) == files
    scene = thenar.Scene.named("bread-grasp")
    assert scene.text == (SCENES / "bread-grasp.toml").read_text()
    assert scene.title and scene.duration > 0 and scene.time_step == scene.world().time_step


def test_text_file_and_name_give_the_same_world() -> None:
    path = SCENES / "falling-box.toml"
    scenes = [
        thenar.Scene.named("falling-box"),
        thenar.Scene.from_file(path),
        thenar.Scene.from_text(path.read_text()),
    ]
    hashes = set()
    for scene in scenes:
        world = scene.world()
        world.step(10)
        hashes.add(world.state_hash)
    assert len(hashes) == 1


def test_a_scene_is_made_by_a_program(tmp_path: pathlib.Path) -> None:
    made: dict[str, thenar.Value] = {
        "version": 1,
        "title": 'of a "program"',
        "time_step": np.float64(2e-3),
        "gravity": np.array([0.0, -1.0, 0.0]),
        "rigid": [
            {"name": f"ball {k}", "mass": 0.1 + k, "position": (0, k, 0), "shape": {"kind": "sphere", "radius": 0.02}}
            for k in range(3)
        ],
    }
    scene = thenar.Scene.from_dict(made, set={"rigid.2.mass": 7})
    world = scene.world()
    world.step()
    assert scene.title == 'of a "program"'
    assert [body.name for body in world.rigid_bodies] == ["ball 0", "ball 1", "ball 2"]
    assert world.rigid_bodies[1].velocity.array.tolist() == pytest.approx([0.0, -2e-3, 0.0, 0.0, 0.0, 0.0])
    # Its text is a scene file with the same bits.
    (tmp_path / "made.toml").write_text(scene.text, encoding="utf-8")
    again = thenar.Scene.from_file(tmp_path / "made.toml", set={"rigid.2.mass": 7}).world()
    again.step()
    assert again.state_hash == world.state_hash
    with pytest.raises(thenar.SceneError, match="`rigid`: |mass"):
        thenar.Scene.from_dict({"version": 1, "rigid": [{"name": "a", "mass": float("nan")}]})
    with pytest.raises(thenar.SceneError, match="tim_step"):
        thenar.Scene.from_dict({"version": 1, "tim_step": 1})
    with pytest.raises(TypeError, match="NoneType"):
        thenar.Scene.from_dict({"version": None})  # type: ignore[dict-item]


@pytest.mark.parametrize("gravity", [[0.0, -1.0, 0.0], (0, -1, 0), np.array([0.0, -1.0, 0.0]), np.array([0, -1, 0])])
def test_lists_tuples_and_arrays_are_taken(gravity: thenar.Value) -> None:
    world = thenar.Scene.named("falling-box", set={"gravity": gravity, "time_step": np.float64(2e-3)}).world()
    box = world.rigid_bodies[-1]
    world.step()
    # Of a free fall from rest by one step: h times gravity.
    assert world.time_step == 2e-3 and box.velocity.array.tolist() == pytest.approx([0.0, -2e-3, 0.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("title", ['a "quoted" one', "back\\slash", "brød: naïve, 面包 🍞", "a = [1]"])
def test_texts_are_taken_as_they_are(title: str) -> None:
    assert thenar.Scene.named("falling-box", set={"title": title}).title == title


def test_truths_tables_and_words_are_taken() -> None:
    changes: dict[str, thenar.Value] = {
        "hand.0.driven": False,
        "solver": {"kind": "two-step", "cone": "linearised"},
    }
    world = thenar.Scene.named("table-press", set=changes).world()
    assert {setting.key: setting.value for setting in world.settings()}["solver"] == "two-step"
    with pytest.raises(thenar.PoseError, match="driven = false"):
        world.hands[0].follow_angles([0, 0, 0, 0, 0, 0, 1], np.zeros(20))


def words_of_the_program(program: pathlib.Path, *arguments: str) -> str:
    done = subprocess.run([program, *arguments], capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 2, done
    return done.stderr.strip().removeprefix("error: ")


def test_errors_have_the_words_of_the_program(program: pathlib.Path, tmp_path: pathlib.Path) -> None:
    scene = tmp_path / "wrong.toml"
    scene.write_text('version = 1\ntime_stp = 0.001\n[[rigid]]\nname = "a"\n')
    absent = tmp_path / "absent.toml"
    pinch = SCENES / "pinch.toml"
    wanted: list[tuple[Callable[[], thenar.Scene], list[str]]] = [
        (lambda: thenar.Scene.from_file(scene), ["run", str(scene)]),
        (lambda: thenar.Scene.from_file(absent), ["run", str(absent)]),
        (lambda: thenar.Scene.named("bred-grasp"), ["run", "bred-grasp"]),
        (
            lambda: thenar.Scene.from_file(pinch, set={"solver.con": "circular"}),
            ["run", str(pinch), "--set", 'solver.con="circular"'],
        ),
        (
            lambda: thenar.Scene.from_file(pinch, set={"time_step": -1.0}),
            ["run", str(pinch), "--set", "time_step=-1.0"],
        ),
    ]
    for make, arguments in wanted:
        with pytest.raises(thenar.SceneError) as caught:
            make()
        assert str(caught.value) == words_of_the_program(program, *arguments)


def test_what_only_building_finds_is_told_by_world() -> None:
    scene = thenar.Scene.named("pinch", set={"hand.0.model": "neither"})
    with pytest.raises(thenar.SceneError, match="neither"):
        scene.world()


def test_values_that_no_scene_knows_are_refused() -> None:
    with pytest.raises(TypeError, match="object"):
        thenar.Scene.named("pinch", set={"time_step": object()})  # type: ignore[dict-item]
    with pytest.raises(thenar.SceneError, match="`=`"):
        thenar.Scene.named("pinch", set={"a=b": 1})
    with pytest.raises(thenar.SceneError, match="time_step"):
        thenar.Scene.named("pinch", set={"time_step": float("nan")})
