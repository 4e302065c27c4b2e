"""The notebooks of the guide run, and so does the code of its page on Python.

With JOINTID_WRITE=1 the notebooks are written with what they print and draw.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

GUIDE = Path(__file__).parents[2] / "src/guide"
NOTEBOOKS = {"own-data": 4, "diagnosed": 3, "fleet": 1}


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_notebooks_run_and_draw(name):
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    file = GUIDE / f"notebooks/{name}.ipynb"
    book = nbformat.read(file, 4)
    printed = texts(book)
    nbclient.NotebookClient(book, timeout=600, kernel_name="python3").execute()
    figures = 0
    for cell in (cell for cell in book.cells if cell.cell_type == "code"):
        cell.execution_count = None
        cell.metadata.clear()
        # Progress is on stderr.
        cell.outputs = [output for output in cell.outputs if output.get("name") != "stderr"]
        for output in cell.outputs:
            assert output.output_type != "error", output
            output.pop("execution_count", None)
            figures += "image/png" in output.get("data", {})
            if output.output_type == "execute_result":
                output["execution_count"] = None
    assert figures == NOTEBOOKS[name]
    if os.environ.get("JOINTID_WRITE"):
        nbformat.write(book, file)
    else:
        assert texts(book) == printed


def texts(book):
    """Return what the cells of a notebook print."""
    outputs = [output for cell in book.cells if cell.cell_type == "code" for output in cell.outputs]
    return "".join(output.text for output in outputs if output.get("name") == "stdout")


def test_the_notebooks_of_the_guide_are_all_tested():
    assert {file.stem for file in (GUIDE / "notebooks").glob("*.ipynb")} == set(NOTEBOOKS)


def test_the_code_of_the_page_on_python_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(
        r"^```python\n(.*?)^```", (GUIDE / "python.md").read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
    )
    assert len(blocks) >= 4
    names: dict = {"__name__": "guide"}
    for block in blocks:
        exec(compile(block, "python.md", "exec"), names)  # noqa: S102
