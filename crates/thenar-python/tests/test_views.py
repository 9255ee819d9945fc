"""Goal: arrays have the shapes and numbers that the documents say, and know when they are stale. Method: a hand that
presses on a table, sums worked out apart, and worlds that go on while arrays are held."""

import gc
from typing import Any

import numpy as np
import pytest

import thenar
from conftest import PAPER, pressing


@pytest.fixture(scope="module")
def world() -> thenar.World:
    return pressing()


def test_shapes_and_types(world: thenar.World) -> None:
    hand = world.hands[0]
    bones = len(hand.bone_names)
    assert bones == 16 and len(hand.joint_names) == 15 and len(hand.bone_parts) == 16
    assert hand.nodes.shape[1] == 3 and hand.velocities.shape == hand.nodes.shape
    assert hand.bone_poses.shape == (16, 7) and hand.bone_velocities.shape == (16, 6)
    assert hand.vertices.shape == hand.vertex_force.shape == (len(hand.vertex_pressure), 3)
    assert hand.surface.dtype == np.uint32 and hand.surface.shape[1] == 3
    assert hand.surface.max() == len(hand.vertices) - 1 and hand.surface is hand.surface
    assert hand.loads.shape == (6,) and hand.angles.shape == (20,) and hand.wrist.shape == (7,)
    assert world.contacts.dtype == thenar.CONTACT and thenar.CONTACT.itemsize == 144
    assert {body.name for body in world.bodies} >= {hand.name, f"{hand.name}/palm"}


def test_quaternions_are_unit_and_skin_is_closed(world: thenar.World) -> None:
    hand = world.hands[0]
    assert np.allclose(np.linalg.norm(hand.bone_poses[:, 3:], axis=1), 1.0, atol=1e-12)
    # Of a closed surface the vector areas of all triangles sum to zero, and the volume is positive.
    a, b, c = np.moveaxis(hand.vertices[hand.surface], 1, 0)
    areas = np.cross(b - a, c - a) / 2
    assert np.abs(areas.sum(axis=0)).max() < 1e-12 and np.einsum("ij,ij->i", areas, a).sum() / 3 > 1e-4


def test_forces_of_points_vertices_and_parts_are_the_same(world: thenar.World) -> None:
    hand = world.hands[0]
    contacts = world.contacts.array
    flesh = world.bodies.index(hand.flesh)
    bones = [i for i, body in enumerate(world.bodies) if body.name.startswith(f"{hand.name}/")]
    on_skin = sum(
        (np.where(contacts["bodies"][:, [side]] == flesh, sign * contacts["force"], 0.0)).sum(axis=0)
        for side, sign in [(0, 1.0), (1, -1.0)]
    )
    on_bones = sum(
        (np.where(np.isin(contacts["bodies"][:, [side]], bones), sign * contacts["force"], 0.0)).sum(axis=0)
        for side, sign in [(0, 1.0), (1, -1.0)]
    )
    size = np.linalg.norm(contacts["force"], axis=1).sum()
    assert size > 1.0 and world.report.contacts == len(contacts)
    assert np.abs(hand.vertex_force.array.sum(axis=0) - on_skin).max() < 1e-12 * size
    assert np.abs(hand.loads["force"].sum(axis=0) - on_skin - on_bones).max() < 1e-12 * size
    # The table pushes up.
    assert on_skin[1] > 0.9 * size
    normal = np.einsum("ij,ij->i", contacts["force"], contacts["normal"])
    tangential = contacts["force"] - normal[:, None] * contacts["normal"]
    bound = contacts["friction"] * normal
    assert (np.linalg.norm(tangential, axis=1) <= bound * (1 + 1e-6) + 1e-9).all()
    assert (np.abs(np.einsum("ij,ij->i", contacts["slip"], contacts["normal"])) < 1e-12).all()
    assert hand.loads["normal"].sum() == pytest.approx(normal.sum(), rel=1e-12)
    pressed = hand.vertex_pressure.array > 0
    assert pressed.any() and (np.linalg.norm(hand.vertex_force.array, axis=1)[~pressed] == 0).all()


def test_a_view_is_one_read_only_array(world: thenar.World) -> None:
    nodes = world.hands[0].nodes
    array = nodes.array
    assert nodes is world.hands[0].nodes and nodes.array is array
    assert np.asarray(nodes) is array or np.shares_memory(np.asarray(nodes), array)
    assert not array.flags.writeable and array.flags.c_contiguous and array.flags.aligned
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 0.0
    with pytest.raises(ValueError):
        array.flags.writeable = True
    assert nodes.copy().flags.writeable
    assert np.asarray(nodes, dtype=np.float32).dtype == np.float32
    assert np.array(nodes).flags.writeable and not np.shares_memory(np.array(nodes), array)


def test_a_view_is_used_as_an_array(world: thenar.World) -> None:
    nodes = world.hands[0].nodes
    array = nodes.array
    assert np.array_equal(nodes - array, np.zeros_like(array)) and np.array_equal(2 * nodes, array + array)
    assert np.array_equal(np.ones(3) - nodes, 1 - array) and isinstance(nodes + nodes, np.ndarray)
    assert np.array_equal(np.linalg.norm(nodes, axis=1), np.linalg.norm(array, axis=1))
    assert np.add.reduce(nodes).shape == (3,) and len(nodes) == len(array) == len(list(nodes))
    assert np.array_equal(nodes[::2, 1], array[::2, 1])
    with pytest.raises(TypeError, match="read-only"):
        nodes += 1.0


@pytest.mark.parametrize("change", ["step", "reset", "set_state"])
def test_a_stale_view_raises_and_an_array_stays(change: str) -> None:
    world = thenar.Scene.named("table-press", set=PAPER).world()
    state = world.state()
    world.step(3)
    hand = world.hands[0]
    views: list[thenar.View[Any]] = [hand.nodes, hand.velocities, hand.bone_poses, hand.vertices, hand.angles]
    views += [hand.loads, world.contacts]
    unread = hand.vertex_force
    arrays = [view.array for view in views]
    kept = [array.tobytes() for array in arrays]
    assert not any(view.is_stale for view in views)
    world.step(0)
    assert not any(view.is_stale for view in views)
    if change == "step":
        world.step()
    elif change == "reset":
        world.reset()
    else:
        world.set_state(state)
    for view in [*views, unread]:
        assert view.is_stale and "stale" in repr(view)
        with pytest.raises(thenar.StaleViewError, match="a step that is past"):
            view.array
        with pytest.raises(thenar.StaleViewError):
            np.asarray(view)
        with pytest.raises(thenar.StaleViewError):
            view[0]
        with pytest.raises(thenar.StaleViewError):
            view + 1
    assert [array.tobytes() for array in arrays] == kept
    assert hand.nodes is not views[0] and hand.nodes.shape == arrays[0].shape


def test_a_failed_change_leaves_views_fresh() -> None:
    world = thenar.Scene.named("falling-box").world()
    view = world.rigid_bodies[0].pose
    with pytest.raises(thenar.StateError):
        world.set_state(b"nothing")
    assert not view.is_stale and view.shape == (7,)


def test_arrays_outlive_the_world_and_views_keep_it() -> None:
    world = thenar.Scene.named("soft-cube").world()
    world.step()
    view, array = world.soft_bodies[0].nodes, world.soft_bodies[0].vertices.array
    bits = array.tobytes()
    del world
    gc.collect()
    assert array.tobytes() == bits
    assert view.shape[1] == 3 and not view.is_stale


def test_what_is_not_there_is_refused(world: thenar.World) -> None:
    with pytest.raises(KeyError, match="no body `nobody`"):
        world.body("nobody")
    native = world._native
    with pytest.raises(IndexError, match="index 99"):
        native.read("nodes", 99, native.generation())
    with pytest.raises(ValueError, match="no quantity `shoes`"):
        native.read("shoes", 0, native.generation())
