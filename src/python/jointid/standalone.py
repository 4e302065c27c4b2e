"""Work that needs no study: peaks, plans, friction, the library of effects."""

from __future__ import annotations

import os
from typing import Any

from . import _arrays, _core
from ._progress import Callback, progress_of, running_of
from .machine import Machine
from .measurement import MeasurementSet
from .parameters import Interval
from .results import Document, Friction, Peaks, Plan
from .study import Study

Path = str | os.PathLike[str]


def peaks(
    measurements: MeasurementSet | Path,
    *,
    band_hz: Interval | None = None,
    local: bool = False,
    max_order: int | None = None,
    threads: int | None = None,
    progress: bool | Callback | None = None,
) -> Peaks:
    """Extracts natural frequencies, damping ratios and amplitudes from the FRFs of a set, and tracks them over its positions.

    `band_hz` restricts the lines; with `local` only the modes in it are fitted, and the others enter as background. `max_order` is the highest polynomial
    order of the stabilisation diagram (48). Ctrl-C ends the work within half a second.

    >>> jd.peaks(taps, band_hz=(20, 300)).modes_csv.splitlines()[0]
    'position,order,frequency_hz,amplitude'
    """
    read = MeasurementSet.of(measurements)
    band, order = _arrays.band("band_hz", band_hz), _arrays.optional_count("max_order", max_order, 8)
    with progress_of(progress, "peaks") as callback:
        text, table = _core.peaks(read._core, band, bool(local), order, running_of(callback, threads))
    return Peaks(text, table, read)


def plan(
    machine: Path | Machine | None = None, measurements: Path | MeasurementSet | None = None, **request: Any
) -> Plan:
    """Ranks choices of measurements, see :meth:`Study.plan`.

    >>> len(jd.plan(choose=2).best)
    2
    """
    return Study(machine, measurements).plan(**request)


def friction(
    path: Path, *, lead_m: float | None = None, efficiency: float = 1.0, noise: str | None = None
) -> Friction:
    """Fits a Stribeck curve to a table with the columns `velocity_m_s` and `force_n` (or `torque_nm`: then give the lead in m per revolution).

    >>> jd.friction(friction_table).parameters["coulomb_n"].unit
    'N'
    """
    lead = None if lead_m is None else _arrays.number("lead_m", lead_m)
    text = _core.friction(
        _arrays.path("path", path),
        lead,
        _arrays.number("efficiency", efficiency),
        _arrays.optional_name("noise", noise),
    )
    return Friction(text)


def effects(id: str | None = None, *, machine: Path | None = None) -> Document:
    """Lists the library of effects, with those of a machine's description where one is named; or the one with an id.

    >>> jd.effects("rotor-hold")["effects"][0]["id"]
    'rotor-hold'
    """
    return Document(
        _core.effects(
            None if machine is None else _arrays.path("machine", machine), _arrays.optional_name("id", id)
        )
    )
