"""Goal: worlds step, go back and forth, follow hands, and refuse what makes no sense, with the bits of the state as
witness. Method: hashes; poses; threads and signals."""

import threading
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

import thenar
from conftest import PAPER, pressing


def hashes(world: thenar.World, steps: int) -> list[int]:
    """The hash after each of so many steps."""
    told = []
    for _ in range(steps):
        world.step()
        told.append(world.state_hash)
    return told


def test_a_state_goes_on_with_the_same_bits_here_and_in_another_world() -> None:
    world = pressing()
    world.set("friction", 0.35)
    state, time_then, steps_then = world.state(), world.time, world.steps
    expected = hashes(world, 15)
    world.set_state(state)
    assert (world.time, world.steps) == (time_then, steps_then) and world.contacts.size == 0
    assert world.state() == state
    assert hashes(world, 15) == expected
    other = thenar.Scene.named("table-press", set=PAPER).world()
    other.set_state(state)
    assert hashes(other, 15) == expected
    assert dict((s.key, s.value) for s in other.settings())["friction"] == 0.35


def test_a_tracked_hand_is_part_of_the_state() -> None:
    world = thenar.Scene.named("free-motion", set=PAPER).world()
    hand = world.hands[0]
    wrist, angles = hand.wrist.copy(), hand.angles.copy()

    def move(steps: range) -> list[int]:
        told = []
        for k in steps:
            hand.follow_angles(wrist + np.array([1e-3 * k, 0, 0, 0, 0, 0, 0]), angles, time=1e-2 * k)
            told += hashes(world, 1)
        return told

    move(range(10))
    state = world.state()
    expected = move(range(10, 20))
    assert hand.mover == "live"
    world.set_state(state)
    assert move(range(10, 20)) == expected


def test_fingertips_come_to_places() -> None:
    world = thenar.Scene.named("free-motion", set=PAPER).world()
    hand = world.hands[0]
    wrist = np.array([0.0, 0.3, 0.0, 0.0, 0.0, 0.0, 1.0])
    angles, miss = hand.reaching(wrist, {"index": [-0.02, 0.26, -0.13], "middle": [0.0, 0.26, -0.13]})
    assert angles.shape == (20,) and miss < 1e-3
    rest = np.array([angle.rest for angle in hand.angle_ranges if angle is not None])
    assert np.allclose(angles[[12, 14, 15]], rest[[12, 14, 15]]) and (angles[[4, 6, 7]] != rest[[4, 6, 7]]).all()
    hand.follow_angles(wrist, angles)
    _, far = hand.reaching(wrist, {"index": [0.0, 0.3, -0.9]})
    assert 0.5 < far < 0.9
    wrongs: list[tuple[dict[str, list[float]], str]] = [
        ({"toe": [0.0, 0.0, 0.0]}, "no finger is named 'toe'"),
        ({"index": [0.0, 0.0, float("nan")]}, "not finite"),
    ]
    for wrong, words in wrongs:
        with pytest.raises(ValueError, match=words):
            hand.reaching(wrist, wrong)
    with pytest.raises(thenar.PoseError):
        hand.reaching(np.full(7, np.nan), {})


def test_states_that_do_not_fit_change_nothing() -> None:
    world = thenar.Scene.named("falling-box").world()
    world.step(5)
    state, bits = world.state(), world.state_hash
    bent = bytearray(state)
    bent[len(bent) // 2] ^= 1
    for wrong, words in [
        (b"", "no state"),
        (state[:-1], "damaged"),
        (bytes(bent), "damaged"),
        (thenar.Scene.named("soft-cube").world().state(), "another scene"),
        (thenar.Scene.named("falling-box", set={"time_step": 0.004}).world().state(), "another scene"),
    ]:
        with pytest.raises(thenar.StateError, match=words):
            world.set_state(wrong)
    assert world.state_hash == bits


def test_reset_goes_back_to_the_start() -> None:
    world = thenar.Scene.named("table-press", set=PAPER).world()
    start = world.state_hash
    first = hashes(world, 10)
    world.reset()
    assert (world.time, world.steps, world.state_hash) == (0.0, 0, start)
    assert hashes(world, 10) == first


def test_numbers_of_steps_are_checked() -> None:
    world = thenar.Scene.named("falling-box").world()
    world.step(0)
    assert world.steps == 0
    for wrong in (-1, -(10**30)):
        with pytest.raises(ValueError, match="0 or more steps"):
            world.step(wrong)
    with pytest.raises(TypeError):
        world.step(1.5)  # type: ignore[arg-type]
    world.step(np.int64(2))  # type: ignore[arg-type]
    assert world.steps == 2 and world.time == pytest.approx(2 * world.time_step)


def test_the_report_tells_of_the_last_step() -> None:
    world = pressing()
    report = world.report
    contacts = world.contacts.array
    assert report.contacts == len(contacts)
    assert report.contacts_active == (np.linalg.norm(contacts["force"], axis=1) > 0).sum() > 0
    assert report.contacts_dropped == 0 and not report.taken_back and report.failure is None
    assert "sound" in repr(report) and world.steps_taken_back == 0


def joints(wrist: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Joints of a flat hand in the order of WebXR, with the wrist at rest there: fingers along -z."""
    rows = np.tile(wrist, (25, 1))
    k = 1
    for finger, count in enumerate([4, 5, 5, 5, 5]):
        for place in range(count):
            rows[k, :3] += [0.02 * (finger - 2), 0.0, -0.03 * (place + 1)]
            k += 1
    assert k == 25
    return rows


def test_a_hand_follows_joints_and_goes_back_to_its_script() -> None:
    world = thenar.Scene.named("free-motion", set=PAPER).world()
    hand = world.hands[0]
    assert hand.mover == "script"
    goal = np.array([0.05, 0.3, 0.1, 0.0, 0.0, 0.0, 1.0])
    for k in range(200):
        hand.follow(joints(goal), np.full(25, 0.01), time=k * world.time_step)
        world.step()
    assert hand.mover == "live"
    assert np.linalg.norm(hand.wrist[:3] - goal[:3]) < 5e-3
    hand.lose()
    assert hand.mover == "lost"
    hand.follow_script()
    assert hand.mover == "script"


def test_a_hand_is_led() -> None:
    world = thenar.Scene.named("free-motion", set=PAPER).world()
    hand = world.hands[0]
    goal = hand.bone_poses.copy()
    goal[:, 1] += 0.02
    for _ in range(200):
        hand.lead(goal)
        world.step()
    assert np.abs(hand.bone_poses[:, :3] - goal[:, :3]).max() < 1e-3
    hand.let_go()
    assert hand.mover == "script"


def test_a_hand_grips_what_is_under_it_and_lets_go() -> None:
    scene = thenar.Scene.named("ball-grip", set={**PAPER, "hand.0.grip.0.at": 100.0, "hand.0.grip.0.open": 200.0})
    world = scene.world()
    hand = world.hands[0]
    world.step(90)
    assert hand.grip_state is None
    assert hand.grip(kind="pinch", force=1.5) == "ball"
    world.step(120)
    state = hand.grip_state
    assert state is not None and state.kind == "pinch" and state.phase == "holding" and state.trouble is None
    # Half of the normal forces on thumb and index finger.
    assert abs(state.force - 1.5) < 0.15 and state.wanted == 1.5
    assert abs(hand.loads["normal"][1:3].sum() / 2 - state.force) < 0.1
    world.step(100)
    assert world.body("ball").pose[1] > 0.1
    kept, same = world.state(), world.state_hash
    hand.release()
    world.step(60)
    assert hand.grip_state is None
    assert world.body("ball").pose[1] < 0.1
    world.set_state(kept)
    assert world.state_hash == same
    state = hand.grip_state
    assert state is not None and state.phase == "holding"


def test_grips_that_cannot_be_had_are_refused_and_change_nothing() -> None:
    world = thenar.Scene.named("ball-grip", set=PAPER).world()
    hand = world.hands[0]
    with pytest.raises(thenar.GripError, match='no body is named "egg"; there are .*"ball"'):
        hand.grip("egg")
    with pytest.raises(thenar.GripError, match="no kind of grip is named \"grab\"; there are pinch, tripod"):
        hand.grip("ball", kind="grab")
    with pytest.raises(thenar.GripError, match="more than 0"):
        hand.grip("ball", force=0.0)
    with pytest.raises(thenar.GripError, match="more than 0"):
        hand.grip("ball", force=float("nan"))
    assert hand.grip_state is None


def test_poses_that_are_none_are_refused_and_change_nothing() -> None:
    world = thenar.Scene.named("free-motion", set=PAPER).world()
    world.step(3)
    hand, state = world.hands[0], world.state()
    good = joints(np.array([0.0, 0.3, 0.0, 0.0, 0.0, 0.0, 1.0]))
    nan, far, bent = good.copy(), good.copy(), good.copy()
    nan[3, 1], far[5, 0], bent[24, 3:] = np.nan, 99.0, 0.7
    for wrong, error, words in [
        (nan, thenar.PoseError, "thumb-phalanx-distal is not a finite number"),
        (far, thenar.PoseError, "index-finger-metacarpal is 99.0 m from the origin"),
        (bent, thenar.PoseError, "the quaternion of pinky-finger-tip has length"),
        (good[:24], ValueError, r"joints: expected an array of shape \(25, 7\), got \(24, 7\)"),
        (good.astype(complex), TypeError, "expected real numbers, got complex128"),
        (good.astype(str), TypeError, "expected real numbers"),
    ]:
        with pytest.raises(error, match=words):
            hand.follow(wrong)
    with pytest.raises(thenar.PoseError, match="radius of wrist"):
        hand.follow(good, np.full(25, -1.0))
    with pytest.raises(thenar.PoseError, match="time"):
        hand.follow(good, time=float("inf"))
    with pytest.raises(thenar.PoseError, match="a joint angle"):
        hand.follow_angles(good[0], np.full(20, np.nan))
    with pytest.raises(ValueError, match=r"wrist: expected an array of shape \(7,\), got \(1, 7\)"):
        hand.follow_angles(good[:1], np.zeros(20))
    with pytest.raises(ValueError, match=r"angles: expected an array of shape \(20,\), got \(\)"):
        hand.follow_angles(good[0], 0.0)
    for wrong_kind in (np.zeros(20, dtype=bool), np.zeros(20, dtype=object), np.zeros(20, dtype="datetime64[s]")):
        with pytest.raises(TypeError, match="angles: expected real numbers"):
            hand.follow_angles(good[0], wrong_kind)
    poses = hand.bone_poses.copy()
    with pytest.raises(thenar.PoseError, match="quaternion of palm"):
        hand.lead(np.zeros_like(poses))
    with pytest.raises(ValueError, match=r"poses: expected an array of shape \(16, 7\), got \(15, 7\)"):
        hand.lead(poses[:15])
    with pytest.raises(ValueError, match=r"velocities: expected an array of shape \(16, 6\)"):
        hand.lead(poses, np.zeros((16, 3)))
    poses[2, 0] = np.inf
    with pytest.raises(thenar.PoseError, match="cannot be led"):
        hand.lead(poses)
    assert world.state() == state


def test_settings_are_checked() -> None:
    world = thenar.Scene.named("table-press", set=PAPER).world()
    wrong: list[tuple[str, float | str, str]] = [
        ("frction", 0.5, "no setting"),
        ("friction", -1.0, "friction"),
        ("friction", float("nan"), "friction"),
        ("gravity", float("inf"), "gravity"),
        ("friction", "high", "friction"),
    ]
    for key, value, words in wrong:
        with pytest.raises(thenar.SettingError, match=words):
            world.set(key, value)
    world.set("solver", "two-step")
    known = {setting.key: setting for setting in world.settings()}
    assert known["solver"].value == "two-step" and known["friction"].unit == "1" and known["friction"].help


def test_two_threads_never_step_one_world() -> None:
    world = pressing()
    start = world.steps
    begun, made, refused = threading.Barrier(2), [0, 0], [0, 0]

    def work(me: int) -> None:
        begun.wait()
        for _ in range(20):
            try:
                world.step(3)
                made[me] += 3
            except thenar.BusyError:
                refused[me] += 1

    threads = [threading.Thread(target=work, args=(me,)) for me in range(2)]
    for thread in threads:
        thread.start()
    # Who reads meanwhile gets a whole step's numbers, or is refused.
    while any(thread.is_alive() for thread in threads):
        try:
            nodes = world.hands[0].nodes.array
            assert np.isfinite(nodes).all()
        except (thenar.BusyError, thenar.StaleViewError):
            pass
    for thread in threads:
        thread.join()
    assert world.steps - start == sum(made) and sum(made) + 3 * sum(refused) == 120
    # The bits are those of one thread that made as many.
    alone = pressing()
    alone.step(sum(made))
    assert alone.state_hash == world.state_hash


def test_other_threads_run_during_a_step_and_are_told_that_the_world_is_taken() -> None:
    world = thenar.Scene.named("table-press", set=PAPER).world()
    thread = threading.Thread(target=world.step, args=(400,))
    thread.start()
    told = 0
    while thread.is_alive():
        try:
            world.state_hash
        except thenar.BusyError as error:
            assert "another thread" in str(error)
            told += 1
    thread.join()
    # Were the interpreter's lock held during a step, nobody would ever see the world taken.
    assert told > 0 and world.steps == 400


def test_numbers_of_any_real_type_and_layout_are_taken_alike() -> None:
    world = thenar.Scene.named("free-motion", set=PAPER).world()
    hand, start = world.hands[0], world.state()
    hashed = set()
    for kind in (np.float64, np.float32, ">f8"):
        world.set_state(start)
        strided = np.zeros(40, dtype=kind)[::2]
        hand.follow_angles(np.array([0.0, 0.25, 0.125, 0.0, 0.0, 0.0, 1.0], dtype=kind), strided, time=0.0)
        hashed.update(hashes(world, 3)[-1:])
    world.set_state(start)
    hand.follow_angles([0, 0.25, 0.125, 0, 0, 0, 1], [0] * 20, time=0.0)
    hashed.update(hashes(world, 3)[-1:])
    assert len(hashed) == 1


def test_a_world_that_another_thread_steps_is_refused_to_everyone() -> None:
    world = thenar.Scene.named("table-press", set=PAPER).world()
    hand = world.hands[0]
    taxels = hand.taxels()
    state = world.state()
    asked: list[Callable[[], object]] = [
        lambda: world.picture(16, 16),
        lambda: world.set("friction", 0.5),
        lambda: world.set_state(state),
        lambda: hand.follow_angles([0, 0.1, 0, 0, 0, 0, 1], np.zeros(20)),
        lambda: taxels.read().array,
        world.reset,
    ]
    thread = threading.Thread(target=world.step, args=(200,))
    thread.start()
    told = 0
    while thread.is_alive() and world_is_free(world):
        pass
    for ask in asked:
        with pytest.raises(thenar.BusyError):
            ask()
        told += 1
    assert thread.is_alive(), "it was too quick to be asked"
    thread.join()
    assert told == len(asked) and world.steps == 200


def world_is_free(world: thenar.World) -> bool:
    try:
        world.time
    except thenar.BusyError:
        return False
    return True


def test_control_c_ends_a_long_step_between_two_steps(control_c: Callable[[], None]) -> None:
    world = thenar.Scene.named("table-press", set=PAPER).world()
    control_c()
    with pytest.raises(KeyboardInterrupt):
        world.step(10**9)
    made = world.steps
    assert 0 < made < 10**9
    again = thenar.Scene.named("table-press", set=PAPER).world()
    again.step(made)
    assert again.state_hash == world.state_hash
