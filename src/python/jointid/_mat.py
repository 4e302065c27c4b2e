"""Documents as MATLAB files."""

from __future__ import annotations

import os
import re
from typing import Any

import numpy as np

from . import _arrays
from ._errors import InputError, needs

# MATLAB's namelengthmax.
_LONGEST = 63
# Text that a MATLAB file begins with, and its number of bytes.
_FIRST_LINE = "MATLAB 5.0 MAT-file of jointid, a machine's joints"
_FIRST_BYTES = 116


def to_mat(path: str | os.PathLike[str], name: str, document: dict[str, Any], *, replace: bool) -> None:
    """Writes a document as one struct of a MATLAB file."""
    try:
        from scipy.io import savemat
    except ImportError:
        raise needs("SciPy", "matlab", "a MATLAB file") from None
    import io

    from .measurement import write

    target = _arrays.path("path", path)
    if not target.endswith(".mat"):
        raise InputError(f"{target}: is no name of a MATLAB file; end it with .mat", file=target, key="path")
    content = io.BytesIO()
    savemat(content, {name: _value(document)}, long_field_names=True, oned_as="column")
    # The first line of SciPy is that of everybody's files; by this one a file of jointid is recognised.
    text = _FIRST_LINE.ljust(_FIRST_BYTES).encode("ascii")
    write(target, text + content.getvalue()[_FIRST_BYTES:], replace=replace)


def _value(value: Any) -> Any:
    if isinstance(value, dict):
        return _struct(value)
    if value is None:
        return np.zeros((0, 0))
    if isinstance(value, list):
        return _list(value)
    return value


def _struct(document: dict[str, Any]) -> dict[str, Any]:
    fields: dict[str, Any] = {}
    for key, value in document.items():
        name = re.sub(r"\W", "_", key, flags=re.ASCII)
        name = (name if name[:1].isalpha() else f"x{name}")[:_LONGEST]
        number = 1
        while name in fields:
            number += 1
            name = f"{name[: _LONGEST - 4]}_{number}"
        fields[name] = _value(value)
    return fields


def _list(values: list[Any]) -> np.ndarray:
    numbers = [np.nan if value is None else value for value in values]
    try:
        array = np.array(numbers)
    except ValueError:
        array = np.array(None)
    if values and array.dtype.kind in "biuf":
        return array
    cell = np.empty(len(values), dtype=object)
    cell[:] = [_value(value) for value in values]
    return cell
