"""Goal: the example runs and shows a grasp, and the documents' first snippets run. Method: its own numbers."""

import runpy

import pytest

from conftest import ROOT


def test_fingers_press_on_the_bread(capsys: pytest.CaptureFixture[str]) -> None:
    main = runpy.run_path(str(ROOT / "crates/thenar-python/examples/bread.py"))["main"]
    rows = main(2.0)
    assert len(capsys.readouterr().out.splitlines()) == 1 + len(rows) == 21
    # In free air nothing presses; in the grasp the thumb and a finger across do.
    assert sum(rows[0]) == 0.0
    assert any(row[1] > 0.1 and max(row[2:]) > 0.1 for row in rows)


@pytest.mark.parametrize("file", ["README.md", "crates/thenar-python/README.md", "docs/python.md"])
def test_the_first_python_of_a_document_runs(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    block = (ROOT / file).read_text().split("```python\n")[1].split("```")[0]
    exec(compile(block, file, "exec"), {})
    assert capsys.readouterr().out
