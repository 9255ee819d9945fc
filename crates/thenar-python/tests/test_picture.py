"""Goal: pictures show the world, and are those of the program. Method: bytes of the program's own picture; a body of one
colour whose place and colour are known; sizes, layers and cameras that are none."""

import pathlib
import subprocess
from typing import Literal

import numpy as np
import pytest

import thenar

BALL = """
version = 1
[[rigid]]
name = "table"
motion = "fixed"
shape = { kind = "plane" }
[[rigid]]
name = "ball"
mass = 0.1
colour = [0.8, 0.0, 0.0]
position = [0.0, 0.1, 0.0]
shape = { kind = "sphere", radius = 0.03 }
"""


def ball() -> thenar.World:
    return thenar.Scene.from_text(BALL).world()


def test_a_saved_picture_has_the_bytes_of_the_program(program: pathlib.Path, tmp_path: pathlib.Path) -> None:
    scene = tmp_path / "ball.toml"
    scene.write_text(BALL)
    theirs, ours = tmp_path / "theirs.png", tmp_path / "ours.png"
    arguments = [str(program), "run", str(scene), "--seconds", "0.1", "--picture", str(theirs), "--size", "120x80"]
    subprocess.run(arguments, check=True, capture_output=True)
    world = thenar.Scene.from_file(scene).world()
    # The program's camera is chosen as the scene begins: so is this one's, of the same points.
    camera_of_the_start = world.picture(120, 80, quality="still")
    world.reset()
    assert np.array_equal(world.picture(120, 80, quality="still"), camera_of_the_start)
    eye = thenar.Camera((0.1, 0.2, 0.5), (0.0, 0.05, 0.0))
    scene.write_text(BALL + "[camera]\nposition = [0.1, 0.2, 0.5]\ntarget = [0.0, 0.05, 0.0]\nfov_deg = 34\n")
    subprocess.run(arguments, check=True, capture_output=True)
    steps = round(0.1 / world.time_step)
    world.step(steps)
    with_camera = thenar.Scene.from_file(scene).world()
    with_camera.step(steps)
    with_camera.save_picture(ours, 120, 80)
    assert ours.read_bytes() == theirs.read_bytes()
    # And a camera that is given has the place of the scene's.
    assert np.array_equal(world.picture(120, 80, camera=eye), with_camera.picture(120, 80))


def test_a_ball_is_where_its_camera_has_it() -> None:
    world = ball()
    eye = thenar.Camera((0.0, 0.1, 1.0), (0.0, 0.1, 0.0), fov_deg=30.0)
    qualities: tuple[Literal["quick", "movie", "still"], ...] = ("quick", "movie", "still")
    for quality in qualities:
        picture = world.picture(201, 101, camera=eye, quality=quality)
        assert picture.shape == (101, 201, 3) and picture.dtype == np.uint8 and not picture.flags.writeable
        red = picture[..., 0] > 40 + 1.5 * picture[..., 1:].max(axis=-1)
        rows, columns = np.nonzero(red)
        # A sphere of 30 mm, 1 m away, with 15 degrees in 50.5 pixels: its outline is a circle of 5.66 pixels.
        assert abs(rows.mean() - 50) < 1.0 and abs(columns.mean() - 100) < 1.0
        radius = 50.5 / np.tan(np.radians(15)) * 0.03 / np.sqrt(1 - 0.03**2)
        assert red.sum() == pytest.approx(np.pi * radius**2, rel=0.2)
    assert np.array_equal(world.picture(64, 48), world.picture(64, 48))


def test_what_is_no_picture_is_refused(tmp_path: pathlib.Path) -> None:
    world = ball()
    for width, height, words in [(0, 5, "0 x 5"), (-3, 5, "0 x 5"), (9000, 5, "9000 x 5"), (2**70, 1, "expected")]:
        with pytest.raises(ValueError, match=words):
            world.picture(width, height)
    with pytest.raises(TypeError):
        world.picture(1.5, 2)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="shoes"):
        world.picture(8, 8, layers="skin,shoes")
    with pytest.raises(ValueError, match="quality"):
        world.picture(8, 8, quality="best")  # type: ignore[arg-type]
    wrong = [
        (thenar.Camera((0, 0, 0), (0, 0, 0)), "another to look at"),
        (thenar.Camera((np.nan, 0, 0), (0, 0, 0)), "finite"),
        (thenar.Camera((0, 0, 1), (0, 0, 0), 170.0), "1 to 150 degrees"),
        (thenar.Camera((0, 1), (0, 0, 0)), "camera.position: expected an array of shape"),  # type: ignore[arg-type]
    ]
    for camera, words in wrong:
        with pytest.raises(ValueError, match=words):
            world.picture(8, 8, camera=camera)
    with pytest.raises(OSError, match="nowhere"):
        world.save_picture(tmp_path / "nowhere" / "picture.png", 8, 8)
