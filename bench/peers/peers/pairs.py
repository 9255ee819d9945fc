"""`python -m peers.pairs`: rigid shapes in Thenar and parry3d; renews that section of results."""

import subprocess

from .engines import BINARIES, HERE
from .report import machine_in_words, renew

TITLE = "## Pairs of rigid shapes: Thenar and parry3d\n"

WORDS = """\
A thousand placements of each pair from 0.5 mm apart to 0.5 mm deep, shapes of 1 to 3 cm, turned
anyhow or with faces (lines) level; contacts from 1 mm on. *Fresh* is without memory, *kept* with
parry3d's manifolds of a placement 10 µm away (Thenar's rigid pairs have no memory); least of 9
rounds in turn, µs of one thread's processor time per pair. Thenar's time includes the search for
near pairs. *Distance off*: of the lowest point, from the greatest gap between the shapes' extents
along any direction, searched densely and refined. *Off by > 10 µm*, *not found*: apart +
overlapping, of a thousand. *Change*: of the distance by a move of 10 µm, which is its bound, fresh
and kept. *Place*: the middle of the points up to 0.1 mm above the lowest, weighted by how far below
that they are; not what carries a load, which a solver finds from all points.
"""


def section():
    machine = machine_in_words(HERE, "parry3d")
    done = subprocess.run([BINARIES / "pairs"], check=True, capture_output=True, text=True)
    return "\n".join([TITLE, machine, WORDS, done.stdout])


def main():
    renew(HERE / "results.md", TITLE, section())


if __name__ == "__main__":
    main()
