"""FRFs as tables of pandas, one row a line."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ._errors import argument
from ._optional import pandas_for

if TYPE_CHECKING:
    import pandas

    from .measurement import Frf

# Columns that have one value in an FRF.
_CHANNEL = ("position", "record", "response", "excitation", "quantity", "averages")
_LINES = ("frequency_hz", "value", "coherence", "relative_sd")


def frame_of_frfs(frfs: Iterable[Frf]) -> pandas.DataFrame:
    """A table of FRFs."""
    pandas = pandas_for("a table")
    parts = [pandas.DataFrame({key: getattr(frf, key) for key in (*_CHANNEL, *_LINES)}) for frf in frfs]
    if not parts:
        return pandas.DataFrame(columns=[*_CHANNEL, *_LINES])
    return pandas.concat(parts, ignore_index=True)


def records_of_frame(frame: Any) -> list[dict[str, Any]]:
    """The FRFs of a table, as mappings of `MeasurementSet.from_arrays`."""
    pandas = pandas_for("a table")
    if not isinstance(frame, pandas.DataFrame):
        raise argument("frame", f"is a {type(frame).__name__}; give a DataFrame of pandas")
    known = [*_CHANNEL, *_LINES, "real", "imag"]
    strange = [str(column) for column in frame.columns if column not in known]
    if strange:
        raise argument("frame", f"has the column «{strange[0]}»; there are {', '.join(known)}")
    if "value" not in frame and {"real", "imag"} <= set(frame.columns):
        frame = frame.assign(value=frame["real"].to_numpy() + 1j * frame["imag"].to_numpy())
    if not {"frequency_hz", "value"} <= set(frame.columns):
        raise argument("frame", "has no FRF; name its columns frequency_hz and value, or real and imag")
    groups = [key for key in _CHANNEL if key in frame and frame[key].notna().any()]
    parts = [rows for _, rows in frame.groupby(groups, sort=False, dropna=False)] if groups else [frame]
    return [_record(part, groups) for part in parts]


def _record(rows: Any, groups: list[str]) -> dict[str, Any]:
    record: dict[str, Any] = {
        key: rows[key].iloc[0] for key in groups if rows[key].notna().iloc[0]
    }
    if "averages" in record:
        record["averages"] = int(record["averages"])
    record |= {key: np.asarray(rows[key]) for key in ("frequency_hz", "value")}
    noise = [key for key in ("coherence", "relative_sd") if key in rows and rows[key].notna().any()]
    return record | {key: np.asarray(rows[key], dtype=float) for key in noise}
