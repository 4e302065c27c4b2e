"""FRFs of a machine at places of the nut."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _arrays, _core
from ._errors import argument


def places(nut_m: Any, positions: Any) -> tuple[list[float] | None, list[str] | None]:
    """Checks places of the nut, of which there are distances or names."""
    if nut_m is not None and positions is not None:
        raise argument("nut_m", "is given beside positions; give one of them")
    nuts = (
        None
        if nut_m is None
        else [
            _arrays.number("nut_m", at, "give distances in m")
            for at in np.atleast_1d(np.asarray(nut_m, dtype=object))
        ]
    )
    return nuts, None if positions is None else _arrays.names("positions", positions)


def frf_of(
    core: _core.Identification | _core.Study,
    measured: str,
    frequency_hz: Any,
    nut_m: Any,
    positions: Any,
    response: Any,
    excitation: Any,
    quantity: Any,
    closed_loop: bool,
) -> NDArray[np.complex128]:
    """Computes FRFs of a machine at its start values or as identified; of the `measured` quantity where none is named."""
    lines = _arrays.frequencies("frequency_hz", frequency_hz, rising=False)
    nuts, names = places(nut_m, positions)
    given = {
        "nut_m": nuts,
        "positions": names,
        "response": _arrays.optional_name("response", response),
        "excitation": _arrays.optional_name("excitation", excitation),
        "quantity": _arrays.optional_name("quantity", quantity) or measured,
        "closed_loop": bool(closed_loop),
    }
    values = core.frf(given, lines)
    single = (nut_m is not None and np.ndim(nut_m) == 0) or isinstance(positions, str)
    return values[0] if single else values
