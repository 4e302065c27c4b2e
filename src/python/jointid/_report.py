"""Pages of results."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from . import _arrays, _core
from ._errors import argument
from .measurement import write

if TYPE_CHECKING:
    from .results import Document


def report(path: str | os.PathLike[str], documents: Sequence[Document], *, replace: bool) -> list[str]:
    """Writes the page of some documents of one machine; returns what it does not draw, and why."""
    target = _arrays.path("path", path)
    with TemporaryDirectory() as folder:
        kept = None
        for document in documents:
            kind = document.document["schema"].split("/")[1]
            file = Path(folder) / f"{kind}.json"
            if file.exists():
                raise argument("others", f"has a second {kind}; give one document of each kind")
            file.write_text(document.json, encoding="utf-8")
            study = getattr(document, "study", None)
            if study is not None and study.measurements.in_memory and kept is None:
                kept = study.measurements.save(Path(folder) / "measurements")
        html, notes = _core.page(folder, None if kept is None else str(kept))
    write(target, html, replace=replace)
    return notes
