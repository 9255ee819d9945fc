"""Goal: the package gives the bits of the program. Method: the program's recordings are made again here and the other
way round, and hashes are compared step by step."""

import pathlib
import subprocess

import pytest

import thenar

SCENE = "bread-grasp"
STEPS = 120


@pytest.fixture(scope="module")
def recorded(program: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[pathlib.Path, str]:
    """A recording by the program, and what it said."""
    file = tmp_path_factory.mktemp("recorded") / "bread.rec"
    seconds = STEPS * thenar.Scene.named(SCENE).time_step
    arguments = [str(program), "record", SCENE, "--seconds", str(seconds), "--out", str(file)]
    done = subprocess.run(arguments, capture_output=True, text=True, check=True)
    return file, done.stdout


def test_every_step_has_the_bits_of_the_program(recorded: tuple[pathlib.Path, str]) -> None:
    file, said = recorded
    world = thenar.Scene.named(SCENE).world()
    recording = thenar.Recording.open(file)
    frames = []
    for frame in recording:
        world.step()
        # `same` compares with the hash that the program wrote after this step.
        assert frame.same is True
        assert frame.hash == world.state_hash
        frames.append(frame)
    assert [frame.step for frame in frames] == list(range(1, STEPS + 1))
    assert f"state {world.state_hash:016x}" in said
    verdict = recording.verdict
    assert verdict.same and verdict.ended and verdict.steps == verdict.same_steps == STEPS
    assert "thenar" in recording.program and "Python" not in recording.program


def test_many_steps_at_once_have_the_bits_of_single_ones(recorded: tuple[pathlib.Path, str]) -> None:
    world = thenar.Scene.named(SCENE).world()
    world.step(STEPS)
    assert f"state {world.state_hash:016x}" in recorded[1]


def test_the_program_makes_a_recording_of_python_again(program: pathlib.Path, tmp_path: pathlib.Path) -> None:
    file = tmp_path / "python.rec"
    world = thenar.Scene.named("table-press", set={"hand.0.friction": 0.6}).world()
    hand = world.hands[0]
    angles = [angle.rest if angle else 0.0 for angle in hand.angle_ranges]
    with world.record(file, keyframes=0.1):
        for k in range(60):
            hand.follow_angles([0.05, max(0.12 - 2e-3 * k, 0.02), 0.05, 0, 0, 0, 1], angles)
            world.step()
            if k == 20:
                world.set("friction", 0.3)
    assert world.report.contacts_active > 0
    done = subprocess.run([program, "replay", file, "--verify"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done
    assert f"the same bits in all 60 steps" in done.stdout
    assert f"state {world.state_hash:016x}" in done.stdout


def test_a_recording_never_replaces_a_file_and_begins_where_its_scene_does(tmp_path: pathlib.Path) -> None:
    world = thenar.Scene.named("falling-box").world()
    taken = tmp_path / "taken.rec"
    taken.write_bytes(b"mine")
    with pytest.raises(FileExistsError, match="taken.rec is there already"):
        world.record(taken)
    assert taken.read_bytes() == b"mine"
    begin = world.state()
    world.step()
    with pytest.raises(thenar.RecordingError, match="just made"):
        world.record(tmp_path / "late.rec")
    assert not (tmp_path / "late.rec").exists()
    world.set_state(begin)
    recorder = world.record(tmp_path / "good.rec")
    with pytest.raises(thenar.RecordingError, match="already"):
        world.record(tmp_path / "second.rec")
    with pytest.raises(thenar.StateError, match="recorded"):
        world.set_state(begin)
    world.step(3)
    assert recorder.end() == recorder.end() == (tmp_path / "good.rec").stat().st_size
    assert thenar.Recording.open(tmp_path / "good.rec").verify().steps == 3
    # The name is free again once the file is gone, and no sooner.
    world.set_state(begin)
    with pytest.raises(FileExistsError, match="good.rec is there already"):
        world.record(tmp_path / "good.rec")
    (tmp_path / "good.rec").unlink()
    world.record(tmp_path / "good.rec").end()
    assert (tmp_path / "good.rec").exists()


def test_a_disk_that_fills_is_told_and_what_was_written_is_kept(tmp_path: pathlib.Path) -> None:
    resource = pytest.importorskip("resource")
    world = thenar.Scene.named("falling-box").world()
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    recorder = world.record(tmp_path / "cut.rec", keyframes=0.01)
    # No file may grow beyond this [bytes]: as a full disk, but for this process alone.
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, before[1]))
    try:
        world.step(1000)
        with pytest.raises(thenar.RecordingError, match="cannot write .*cut.rec"):
            recorder.end()
        with pytest.raises(OSError, match="full.png"):
            world.save_picture(tmp_path / "full.png", 800, 600)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    # The world goes on as one that was not recorded, and there is no partial file of a picture.
    alone = thenar.Scene.named("falling-box").world()
    alone.step(1001)
    world.step()
    assert world.state_hash == alone.state_hash
    assert [path.name for path in tmp_path.iterdir()] == ["cut.rec"]
    verdict = thenar.Recording.open(tmp_path / "cut.rec").verify()
    assert 100 < verdict.steps < 1000 and verdict.same_steps == verdict.steps and not verdict.ended


def test_what_is_no_recording_is_refused(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "other.rec"
    with pytest.raises(thenar.RecordingError, match="cannot read"):
        thenar.Recording.open(file)
    file.write_bytes(b"something else, long enough to be read as a header of some kind")
    with pytest.raises(thenar.RecordingError, match="is not a Thenar recording"):
        thenar.Recording.open(file)


def test_a_recording_shows_bodies_and_contacts(recorded: tuple[pathlib.Path, str]) -> None:
    recording = thenar.Recording.open(recorded[0])
    world = thenar.Scene.named(SCENE).world()
    assert not recording.hands and recording.next() is not None
    world.step()
    assert (recording.hands[0].nodes.array == world.hands[0].nodes.array).all()
    assert recording.contacts.array.tobytes() == world.contacts.array.tobytes()
    nodes = recording.hands[0].nodes
    recording.next()
    with pytest.raises(thenar.StaleViewError):
        nodes.array
