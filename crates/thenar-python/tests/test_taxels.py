"""Goal: taxels feel all that presses on the parts they are on, in shapes that others use. Method: a hand that presses on
a table, against sums over contact points."""

import numpy as np
import numpy.typing as npt
import pytest

import thenar
from conftest import pressing


@pytest.fixture(scope="module")
def world() -> thenar.World:
    return pressing()


def force_on(world: thenar.World) -> tuple[npt.NDArray[np.float64], float]:
    """Force on the hand, skin and bones, and the sum of the sizes of its points' forces."""
    hand = world.hands[0]
    own = [i for i, body in enumerate(world.bodies) if body is hand.flesh or body.name.startswith(f"{hand.name}/")]
    contacts = world.contacts.array
    total, size = np.zeros(3), 0.0
    for side, sign in [(0, 1.0), (1, -1.0)]:
        forces = contacts["force"][np.isin(contacts["bodies"][:, side], own)]
        total += sign * forces.sum(axis=0)
        size += np.linalg.norm(forces, axis=1).sum()
    return total, size


@pytest.mark.parametrize("rows, columns", [(1, 1), (4, 4), (2, 7)])
def test_the_whole_hand_feels_all_of_it(world: thenar.World, rows: int, columns: int) -> None:
    hand = world.hands[0]
    taxels = hand.taxels("hand", rows=rows, columns=columns)
    read = taxels.read()
    force, size = force_on(world)
    assert len(taxels) == len(read) == rows * columns * len(hand.bone_names) and size > 1.0
    assert [patch.bone for patch in taxels.patches] == list(hand.bone_names)
    assert np.abs(read["force"].sum(axis=0) - force).max() < 1e-12 * size
    assert not taxels.missed.array.any()
    # By the taxels' own axes too.
    n, t, s = np.moveaxis(read["axes"], 1, 0)
    by_axes = t * read["shear"][:, :1] + s * read["shear"][:, 1:] - n * read["normal"][:, None]
    assert np.abs(by_axes.sum(axis=0) - force).max() < 1e-12 * size
    contacts = world.contacts.array
    assert read["area"].sum() == pytest.approx(contacts["area"].sum(), rel=1e-12)


def test_points_of_ones_own_lie_on_the_skin(world: thenar.World) -> None:
    hand = world.hands[0]
    points: dict[str, npt.ArrayLike] = {"index-distal": [[0.0, -0.01, 0.0]], "palm": np.zeros((2, 3))}
    taxels = hand.taxels(points)
    assert taxels.patches == (thenar.Patch("index-distal", 1, 1, 0), thenar.Patch("palm", 2, 1, 1))
    # Each is on the skin as it is now: no farther than round-off from the plane of a triangle of it.
    a, b, c = np.moveaxis(hand.vertices[hand.surface], 1, 0)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    for point in taxels.read()["point"]:
        assert np.abs(np.einsum("ij,ij->i", point - a, normals)).min() < 1e-12
    # Of the one patch on the palm, and of no finger but the index.
    parts = [thenar.PARTS.index("palm"), thenar.PARTS.index("index")]
    force = hand.loads["force"][parts].sum(axis=0)
    assert np.abs(taxels.read()["force"].sum(axis=0) - force).max() < 1e-11


def test_what_is_out_of_reach_is_missed(world: thenar.World) -> None:
    hand = world.hands[0]
    near, all_of_it = hand.taxels("hand", rows=1, columns=1, reach=0.01), hand.taxels("hand", rows=1, columns=1)
    missed = near.missed.array
    felt = near.read()["force"].sum(axis=0)
    assert missed[1] > 0.1 and felt[1] > 0.1
    assert np.allclose(felt + missed, all_of_it.read()["force"].sum(axis=0), rtol=0, atol=1e-11)


def test_shapes_of_others(world: thenar.World) -> None:
    hand = world.hands[0]
    taxels = hand.taxels("fingertips", rows=3, columns=5)
    assert taxels.patch("thumb-distal").shape == (3, 5)
    image = taxels.image("thumb-distal")
    assert image.shape == (3, 3, 5)
    thumb = taxels.patches[0]
    assert thumb == thenar.Patch("thumb-distal", 3, 5, 0) and thumb.stop == 15
    read = taxels.read()
    assert np.array_equal(image[0].ravel(), read["normal"][:15])
    assert np.array_equal(image[2].ravel(), read["shear"][:15, 1])
    normal, shear = thenar.stack_taxels([taxels, taxels])
    assert normal.shape == (2, 75) and shear.shape == (2, 75, 2)
    assert np.array_equal(normal[1], read["normal"]) and np.array_equal(shear[0], read["shear"])
    with pytest.raises(ValueError, match="as many"):
        thenar.stack_taxels([taxels, hand.taxels("hand")])


def test_taxels_go_stale_and_are_read_again() -> None:
    world = pressing()
    taxels = world.hands[0].taxels()
    view, missed = taxels.read(), taxels.missed
    assert taxels.read() is view and view.array is view.array
    bits = view.array.tobytes()
    world.step()
    for old in (view, missed):
        with pytest.raises(thenar.StaleViewError):
            old.array
    assert taxels.read().array.tobytes() != bits
    world.reset()
    assert not taxels.read()["force"].any()


def test_taxels_change_nothing(world: thenar.World) -> None:
    with_taxels, without = pressing(), pressing()
    taxels = with_taxels.hands[0].taxels("hand")
    for _ in range(10):
        with_taxels.step()
        taxels.read().array
    without.step(10)
    assert with_taxels.state_hash == without.state_hash


def test_what_makes_no_sense_is_refused(world: thenar.World) -> None:
    hand = world.hands[0]
    for layout, words in [
        ("toes", "there is no layout `toes`: there are fingertips, hand"),
        ({"index-distal": [[0.0, np.nan, 0.0]]}, "not finite"),
        ({"toe": [[0.0, 0.0, 0.0]]}, "no skin on a bone `toe`"),
        ({"palm": [0.0, 0.0, 0.0]}, r"palm: expected an array of shape \(n, 3\)"),
    ]:
        with pytest.raises(ValueError, match=words):
            hand.taxels(layout)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="rows and columns"):
        hand.taxels(rows=0)
    with pytest.raises(ValueError, match="at most 100000"):
        hand.taxels(rows=10_000, columns=10_000)
    with pytest.raises(ValueError, match="reach"):
        hand.taxels(reach=-1.0)
    other = thenar.Scene.named("soft-cube").world()
    native = world._native.taxels_of(0, "hand", 1, 1, 1.0)
    with pytest.raises(ValueError, match="another world"):
        other._native.read_taxels(native, other._native.generation())
