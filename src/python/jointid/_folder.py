"""Files of a measurement set that was made of arrays."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

_COMMON = ("quantity", "response", "excitation", "averages")
_OF_FRF = ("position", "record", *_COMMON, "force_n", "speed_m_s", "acceleration_m_s2")


def files_of_arrays(
    given: dict[str, Any], records: list[dict[str, Any]], moves: list[dict[str, Any]]
) -> dict[str, bytes]:
    """Contents of manifest and tables by name; numbers with all their digits."""
    files: dict[str, bytes] = {}
    lines = [f"title = {_text(given['title'])}"]
    lines += [f"{key} = {_text(given[key])}" for key in _COMMON if given[key] is not None]
    lines.append(f"gain = {_text('unknown' if given['gain'] is None else given['gain'])}")
    stated = [
        (key, sd)
        for key, sd in zip(("gain", "delay_s", "nut_m"), given["tolerance"], strict=True)
        if sd is not None
    ]
    if stated:
        lines += ["", "[tolerance]", *(f"{key} = {_text(sd)}" for key, sd in stated)]
    if given["fit"] is not None:
        lines += ["", "[split]", f"fit = [{', '.join(map(_text, given['fit']))}]"]
    positions = dict(given["nut_m"]) or {
        record["position"]: None for record in records if record["position"] is not None
    }
    for name, nut_m in positions.items():
        lines += ["", "[[position]]", f"name = {_text(name)}"]
        lines += [] if nut_m is None else [f"nut_m = {_text(nut_m)}"]
    for at, record in enumerate(records):
        file = f"frf/{at + 1}.csv"
        lines += [
            "",
            "[[frf]]",
            f"file = {_text(file)}",
            *(f"{key} = {_text(record[key])}" for key in _OF_FRF if record[key] is not None),
        ]
        columns = {
            "frequency_hz": record["frequency_hz"],
            "real": record["value"].real,
            "imag": record["value"].imag,
        }
        columns |= {key: record[key] for key in ("coherence", "relative_sd") if record[key] is not None}
        files[file] = _table(columns)
    for at, move in enumerate(moves):
        file = f"motion/{at + 1}.csv"
        lines += ["", "[[motion]]", f"name = {_text(move['name'])}", f"file = {_text(file)}"]
        columns = {key: move[key] for key in ("time_s", "command_m", "position_m")}
        columns |= {"torque_nm" if move["is_torque"] else "force_n": move["effort"]} | move["others"]
        files[file] = _table(columns)
    files["manifest.toml"] = ("\n".join(lines) + "\n").encode()
    return files


def _text(value: Any) -> str:
    """A value in TOML."""
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def _table(columns: dict[str, np.ndarray]) -> bytes:
    rows = zip(*(map(repr, column.tolist()) for column in columns.values()), strict=True)
    return "\n".join([",".join(columns), *(",".join(row) for row in rows)]).encode() + b"\n"
