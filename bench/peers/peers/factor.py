"""`python -m peers.factor`: the flesh's Cholesky factor here and in faer; renews that section."""

import subprocess

from .engines import BINARIES, HERE
from .report import machine_in_words, renew

TITLE = "## Factor of the flesh: Thenar and faer\n"

WORDS = """\
The flesh matrix of the shipped right hand at rest (`M + h D + h² K` and the springs to the bones, h =
1 ms): the paper's mesh, the default graded one, and a fine one. One thread, least of 60, 30 and 10
rounds in turn, ms of its processor time. *Plan*: the order of elimination and the structure, once
per world. *Factor*: the matrix read in and factored, in each step that needs it. *16 columns*,
filled in and solved: all full, and the three columns of one node; Thenar's is half a solve (L
alone), which is all that the compliance of contacts needs, and passes over what a column does not
reach; faer has whole solves.
*Numbers*: of the factor, with padding and zeros that supernodes hold. *Error*: of a solution,
largest, relative. *Same bits*: whether twenty factorisations by two threads give those of one.
"""


def section():
    machine = machine_in_words(HERE, "faer")
    done = subprocess.run([BINARIES / "factor"], check=True, capture_output=True, text=True)
    return "\n".join([TITLE, machine, WORDS, done.stdout])


def main():
    renew(HERE / "results.md", TITLE, section())


if __name__ == "__main__":
    main()
