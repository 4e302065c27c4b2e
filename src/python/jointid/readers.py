"""Measurement sets from files of other programs: universal files and tables."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from . import _arrays, _core
from ._errors import argument
from .measurement import MeasurementSet


def read_uff(
    files: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    quantity: str | None = None,
    averages: int | None = None,
    response: str | None = None,
    excitation: str | None = None,
    nut_m: Mapping[str, float] | None = None,
    position: str | None = None,
    pattern: str | None = None,
    map: str | os.PathLike[str] | None = None,
    strict: bool = False,
    accept_truncated: bool = False,
    title: str | None = None,
) -> MeasurementSet:
    """Reads universal files (dataset 58 and 58b) as a measurement set.

    Parameters
    ----------
    files : path or list of paths
    quantity : {"receptance", "mobility", "accelerance"}
        Measured quantity, where the file does not state it.
    averages : int
        Number of averages, which no universal file states; needed to use a coherence.
    response, excitation : str
        Points of the machine; those of the file where absent.
    nut_m : mapping of position to float
        Nut positions (m).
    position : str
        Position of all records.
    pattern : str
        Pattern with {} for the position's name, in file names, ID lines or entities.
    map : path
        Table with the columns record,position,response,excitation.
    strict : bool
        Whether any faulty part refuses its file; otherwise sound parts are read, and `warnings` names the rest.
    accept_truncated : bool
        Whether files that end inside their data are accepted.

    Raises
    ------
    InputError
        A file cannot be read or holds no FRF, or names do not fit its records.

    Examples
    --------
    >>> notes = taps.to_uff("taps.uff", replace=True)
    >>> list(jd.read_uff("taps.uff", pattern="position {}", nut_m={"p1": 0.6, "p2": 1.2, "p3": 1.8}).frfs)
    ['p1', 'p2', 'p3']
    """
    return _imported(
        files,
        None,
        quantity,
        averages,
        response,
        excitation,
        nut_m,
        position,
        pattern,
        map,
        strict,
        accept_truncated,
        title,
    )


def read_tables(
    files: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    columns: Sequence[str] | None = None,
    quantity: str | None = None,
    averages: int | None = None,
    response: str | None = None,
    excitation: str | None = None,
    nut_m: Mapping[str, float] | None = None,
    position: str | None = None,
    pattern: str | None = None,
    map: str | os.PathLike[str] | None = None,
    title: str | None = None,
) -> MeasurementSet:
    """Reads FRFs from tables of other programs (.csv, .tsv, .txt, .dat, .asc); `columns` names their columns in place of a header. Else as
    :func:`read_uff`.

    >>> folder = taps.save("taps", replace=True)
    >>> tap = jd.read_tables("taps/frf/1.csv", quantity="receptance", response="table", excitation="table", position="p1", nut_m={"p1": 0.6})
    >>> list(tap.frfs)
    ['p1']
    """
    named = None if columns is None else _arrays.names("columns", columns)
    return _imported(
        files,
        named,
        quantity,
        averages,
        response,
        excitation,
        nut_m,
        position,
        pattern,
        map,
        True,
        False,
        title,
    )


def _imported(
    files: Any,
    columns: list[str] | None,
    quantity: Any,
    averages: Any,
    response: Any,
    excitation: Any,
    nut_m: Any,
    position: Any,
    pattern: Any,
    map: Any,
    strict: bool,
    accept_truncated: bool,
    title: Any,
) -> MeasurementSet:
    several = [files] if isinstance(files, (str, os.PathLike)) else list(files)
    if not several:
        raise argument("files", "is empty; name at least one file")
    paths = [_arrays.path("files", file) for file in several]
    given = {
        "files": paths,
        "columns": columns,
        "strict": bool(strict),
        "accept_truncated": bool(accept_truncated),
        "quantity": _arrays.optional_name("quantity", quantity),
        "position": _arrays.optional_name("position", position),
        "pattern": _arrays.optional_name("pattern", pattern),
        "map": None if map is None else _arrays.path("map", map),
        "nut_m": {
            at: _arrays.number(f"nut_m[{at!r}]", x) for at, x in _arrays.optional_mapping("nut_m", nut_m).items()
        },
        "response": _arrays.optional_name("response", response),
        "excitation": _arrays.optional_name("excitation", excitation),
        "averages": _arrays.optional_count("averages", averages, 1),
        "title": _arrays.optional_name("title", title) or Path(paths[0]).stem,
    }
    return MeasurementSet._of(_core.MeasurementSet.import_files(given))
