"""The notebooks of the guide run, and the code of its page on Python and of the README are scripts that run, fresh and again.

With JOINTID_WRITE=1 the notebooks are written with what they print and draw.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from conftest import taps

import jointid as jd

README = Path(__file__).parents[2] / "README.md"
GUIDE = README.parent / "src/guide"
NOTEBOOKS = {"own-data": 4, "diagnosed": 3, "fleet": 1}


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_notebooks_run_and_draw(name):
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    file = GUIDE / f"notebooks/{name}.ipynb"
    book = nbformat.read(file, 4)
    printed = texts(book)
    # No limit of time: a busy machine is slow.
    nbclient.NotebookClient(book, timeout=None, startup_timeout=3600, kernel_name="python3").execute()
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


def code(page: Path) -> str:
    """Python code of a page, as one script."""
    blocks = re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    assert blocks, page
    return "\n".join(blocks)


def run_twice(text: str, folder: Path) -> None:
    """Runs a script in a folder, and again where the first run has left its files."""
    (folder / "script.py").write_text(text, encoding="utf-8")
    environment = os.environ | {"MPLBACKEND": "Agg"}
    for _ in range(2):
        ran = subprocess.run(
            [sys.executable, "script.py"], cwd=folder, env=environment, capture_output=True, text=True, check=False
        )
        assert ran.returncode == 0, ran.stderr
        assert "Traceback" not in ran.stderr


def test_the_page_on_python_is_a_script(tmp_path):
    # The workers of its fleet import the script.
    guarded = 'if __name__ == "__main__":\n' + textwrap.indent(code(GUIDE / "python.md"), "    ")
    run_twice(guarded, tmp_path)


def test_the_code_of_the_readme_follows_its_commands(tmp_path):
    """The published bench stands for the reader's machine."""
    pytest.importorskip("matplotlib")
    readme = README.read_text(encoding="utf-8")
    commands = [line.partition("#")[0].strip() for line in readme.splitlines() if line.startswith("jointid ")]
    of_files = [line for line in commands if line.startswith(("jointid init", "jointid import"))]
    assert len(of_files) == 2
    for command in of_files:
        ran = subprocess.run(
            [sys.executable, "-m", *shlex.split(command)], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert ran.returncode == 0, ran.stderr
        if command.startswith("jointid init"):
            (tmp_path / "axis/machine.toml").write_text(jd.Machine("configs/tian.toml").text, encoding="utf-8")
            own = taps(4e8, 1, nuts={"p1": 0.6, "p2": 1.0, "p3": 1.6})
            own.save(tmp_path / "own")
            (tmp_path / "taps").mkdir()
            for at, name in enumerate(own.frfs):
                shutil.copy(tmp_path / f"own/frf/{at + 1}.csv", tmp_path / f"taps/tap-{name}.csv")
    run_twice(code(README), tmp_path)
