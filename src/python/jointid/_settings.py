"""Settings of identification and diagnosis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

import numpy as np

from . import _arrays
from ._errors import argument


class Settings(TypedDict, total=False):
    """Settings of identification and diagnosis; those left out keep the default of the command.

    objective : {"least-squares", "eq26", "frequencies", "frf", "inverse-dynamics", "output-error"}
        What is minimised; by default whole FRFs where the set has some, inverse dynamics for motion records, else least squares of the modes.
    lumps : int
        Masses per rod of the lumped model; absent for the exact rod.
    frequency_model_error, frf_model_error : float
        Relative standard deviation of natural frequencies and of FRFs due to model error (0.01).
    amplitude_sd : float
        Standard deviation of ln(amplitude) (0.13).
    tolerances : bool
        Whether tolerances of machine and measurement are fitted along with whole FRFs (True).
    band_hz : (float, float)
        Lowest and highest frequency of FRFs (Hz).
    bootstrap : int
        Bootstrap samples over lines, and as many over positions (0).
    freeze : list of str
        Parameters held at their start values.
    repeats : int
        How often the best minimum has to be found from new starts.

    >>> settings: jd.Settings = {"freeze": ["k_m"], "tolerances": False}
    >>> study.identify(**settings).parameters["k_m"].fitted
    False
    """

    objective: str
    lumps: int
    frequency_model_error: float
    frf_model_error: float
    amplitude_sd: float
    tolerances: bool
    band_hz: tuple[float, float]
    bootstrap: int
    freeze: Sequence[str]
    repeats: int


def _boolean(key: str, given: Any) -> bool:
    if not isinstance(given, (bool, np.bool_)):
        raise argument(key, f"is {given!r}; give True or False")
    return bool(given)


CHECKS: dict[str, Any] = {
    "objective": _arrays.name,
    "lumps": lambda key, given: _arrays.count(key, given, 1),
    "frequency_model_error": _arrays.number,
    "frf_model_error": _arrays.number,
    "amplitude_sd": _arrays.number,
    "tolerances": _boolean,
    "band_hz": _arrays.band,
    "bootstrap": _arrays.count,
    "freeze": _arrays.names,
    "repeats": lambda key, given: _arrays.count(key, given, 1),
}


def checked(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Checks settings by name; those that are None are left out."""
    for key in settings:
        if key not in CHECKS:
            raise argument(key, f"is no setting; there are {', '.join(CHECKS)}")
    return {key: CHECKS[key](key, value) for key, value in settings.items() if value is not None}
