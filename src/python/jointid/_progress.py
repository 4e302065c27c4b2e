"""Progress of long work: a bar in terminals and notebooks, or a callback of the caller."""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Any

from . import _arrays
from ._errors import argument

Callback = Callable[[str, "int | None", "int | None"], Any]


def _in_notebook() -> bool:
    shell = sys.modules.get("IPython")
    return shell is not None and shell.get_ipython() is not None and hasattr(shell.get_ipython(), "kernel")


class _Line:
    """Progress in one line of stderr."""

    def __init__(self, name: str) -> None:
        self.name, self.longest = name, 0

    def __call__(self, stage: str, done: int | None, of: int | None) -> None:
        counted = f"  {done}/{of}" if of else ""
        text = f"{self.name}: {stage}{counted}"
        self.longest = max(self.longest, len(text))
        sys.stderr.write("\r" + text.ljust(self.longest))
        sys.stderr.flush()

    def close(self) -> None:
        if self.longest:
            sys.stderr.write("\r" + " " * self.longest + "\r")
            sys.stderr.flush()


class _Bar:
    """Progress as a bar of tqdm, which knows terminals and notebooks."""

    def __init__(self, name: str, tqdm: Any) -> None:
        self.name, self.bar = name, tqdm(desc=name, leave=False)

    def __call__(self, stage: str, done: int | None, of: int | None) -> None:
        self.bar.set_description_str(f"{self.name}: {stage}", refresh=False)
        self.bar.total = of
        self.bar.n = done or 0
        self.bar.refresh()

    def close(self) -> None:
        self.bar.close()


@contextmanager
def progress_of(progress: bool | Callback | None, name: str) -> Generator[Callback | None]:
    """Yields the callback of a work: none, that of the caller, or a bar (by default in terminals and notebooks)."""
    if progress is None:
        progress = sys.stderr is not None and sys.stderr.isatty() or _in_notebook()
    if callable(progress):
        yield progress
        return
    if not isinstance(progress, bool):
        raise argument(
            "progress",
            f"is a {type(progress).__name__}; give True, False, or a function of (stage, done, of)",
        )
    if not progress:
        yield None
        return
    try:
        # The bar of notebooks needs widgets, without which tqdm only warns.
        if _in_notebook() and find_spec("ipywidgets") is None:
            raise ImportError
        from tqdm.auto import tqdm
    except ImportError:
        shown: Any = _Line(name)
    else:
        shown = _Bar(name, tqdm)
    try:
        yield shown
    finally:
        shown.close()


def running_of(callback: Callback | None, threads: int | None) -> dict[str, Any]:
    """How the extension runs a work: its callback and its number of threads."""
    return {"progress": callback, "threads": _arrays.optional_count("threads", threads, 1)}
