"""Refuses to start processes from a script that they would run again."""

from __future__ import annotations

import ast
import sys
from pathlib import Path
from types import FrameType

from ._errors import argument


def require_main_guard() -> None:
    """Refuses to start processes where the main script calls outside of its main guard.

    A new process imports the script of its parent. A call at the top of the script would start processes there, too, and each would end with the traceback
    of multiprocessing.

    Raises
    ------
    InputError
        The call stands at the top of the script.
    """
    file = getattr(sys.modules.get("__main__"), "__file__", None)
    frame: FrameType | None = sys._getframe()
    while frame is not None and file is not None:
        code = frame.f_code
        if code.co_name == "<module>" and frame.f_globals.get("__name__") == "__main__":
            if code.co_filename == file and not _is_guarded(Path(file), frame.f_lineno):
                raise argument(
                    "client",
                    f'starts processes, which import {file} and would run line {frame.f_lineno} again; put it below `if __name__ == "__main__":`',
                )
            return
        frame = frame.f_back


def _is_guarded(file: Path, line: int) -> bool:
    """Whether a line of a script stands below a test of `__name__`."""
    try:
        tree = ast.parse(file.read_bytes())
    except (OSError, SyntaxError, ValueError):
        # What cannot be read is not refused.
        return True
    tests = (node for node in ast.walk(tree) if isinstance(node, ast.If))
    return any(
        test.body[0].lineno <= line <= (test.body[-1].end_lineno or line)
        and any(isinstance(name, ast.Name) and name.id == "__name__" for name in ast.walk(test.test))
        for test in tests
    )
