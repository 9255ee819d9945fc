"""Goal: the example runs and shows a grasp, and the documents' first snippets run. Method: its own numbers."""

import json
import pathlib
import runpy
import sys
from typing import Any

import numpy as np
import pytest

from conftest import ROOT


def test_fingers_press_on_the_bread(capsys: pytest.CaptureFixture[str]) -> None:
    main = runpy.run_path(str(ROOT / "crates/thenar-python/examples/bread.py"))["main"]
    rows = main(2.0)
    assert len(capsys.readouterr().out.splitlines()) == 1 + len(rows) == 21
    # In free air nothing presses; in the grasp the thumb and a finger across do.
    assert sum(rows[0]) == 0.0
    assert any(row[1] > 0.1 and max(row[2:]) > 0.1 for row in rows)


EXAMPLES = ROOT / "crates/thenar-python/examples"


def test_the_notebook_runs_and_ends_with_the_forces_of_the_fingers() -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    cells = json.loads((EXAMPLES / "bread.ipynb").read_text(encoding="utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert all(not cell.get("outputs") for cell in cells), "outputs are not committed"
    names: dict[str, Any] = {}
    for number, text in enumerate(code):
        exec(compile(text, f"bread.ipynb, cell {number}", "exec"), names)
    lines = names["axes"].get_lines()
    forces = np.array([line.get_ydata() for line in lines])
    assert [line.get_label() for line in lines] == ["palm", "thumb", "index", "middle", "ring", "little"]
    # Nothing presses at first; in the end the thumb bears the others, but for how they slant, and the bread is up.
    assert forces[:, 0].max() == 0.0 and forces[1, -1] > 0.5
    assert forces[2:, -1].sum() == pytest.approx(forces[1, -1], rel=0.1)
    assert names["heights"][-1] - names["heights"][0] > 0.05
    matplotlib.pyplot.close("all")


def test_a_learner_gives_the_same_numbers_again_and_by_two_processes(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("matplotlib")
    sys.path.insert(0, str(EXAMPLES))
    try:
        import learn_lift

        told = learn_lift.learn(generations=2, tries=3, seeds=1, seed=1)
        # The first generation again, by two processes; the second follows from it and from the same draws.
        assert learn_lift.learn(generations=1, tries=3, seeds=1, seed=1, processes=2) == told[:1]
    finally:
        sys.path.remove(str(EXAMPLES))
    assert [row.number for row in told] == [0, 1] and all(row.best >= row.mean for row in told)
    # The elite moved: what was learned is not where it began.
    assert np.abs(np.array(told[0].parameters) - learn_lift.MEAN).max() > 1e-3
    learn_lift.write(told, tmp_path / "curve.csv")
    table = np.genfromtxt(tmp_path / "curve.csv", delimiter=",", names=True)
    assert table["best"] == pytest.approx([row.best for row in told], rel=1e-3)
    learn_lift.draw(told, tmp_path / "curve.svg")
    assert (tmp_path / "curve.svg").read_text().count("<path") > 10


def test_the_curve_in_the_documents_is_of_a_learner_that_lifts() -> None:
    table = np.genfromtxt(ROOT / "docs/images/learn-lift.csv", delimiter=",", names=True)
    assert table["lifted"][0] < 0.1 and table["lifted"][-3:].min() > 0.6
    assert table["best"][-1] > table["best"][0]


@pytest.mark.parametrize("file", ["README.md", "crates/thenar-python/README.md", "docs/python.md"])
def test_the_first_python_of_a_document_runs(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    block = (ROOT / file).read_text().split("```python\n")[1].split("```")[0]
    exec(compile(block, file, "exec"), {})
    assert capsys.readouterr().out
