"""Joint stiffness and damping of ball-screw feed drives from hammer tests, and what their models lack.

>>> import jointid as jd
>>> study = jd.Study().fit(["l1", "l3", "l5"])      # the published bench; jd.Study("axis/machine.toml", "axis/measurements") for an own one
>>> found = study.identify(seed=1)
>>> found.parameters["k_n"].value                   # N/m
>>> study.without(["rotor-hold"]).diagnose().verdict

Quantities are in SI units, frequencies in Hz; FRFs are response over force with e^{+iωt}.
"""

from ._processor import check as _check

_check()

from ._core import __version__  # noqa: E402
from ._errors import InputError, StoppedError  # noqa: E402
from .fleet import Fleet, FleetRun, blind_check, coverage  # noqa: E402
from .machine import Machine  # noqa: E402
from .measurement import Frf, MeasurementSet, read_tables, read_uff  # noqa: E402
from .results import (  # noqa: E402
    Comparison,
    Diagnosis,
    Draws,
    Effect,
    Friction,
    Parameter,
    Parameters,
    Peaks,
    Plan,
    Prediction,
    Validation,
    Verdict,
)
from .study import Identification, Study, effects, friction, peaks, plan  # noqa: E402

__all__ = [
    "Comparison",
    "Diagnosis",
    "Draws",
    "Effect",
    "Fleet",
    "FleetRun",
    "Frf",
    "Friction",
    "Identification",
    "InputError",
    "Machine",
    "MeasurementSet",
    "Parameter",
    "Parameters",
    "Peaks",
    "Plan",
    "Prediction",
    "StoppedError",
    "Study",
    "Validation",
    "Verdict",
    "__version__",
    "blind_check",
    "coverage",
    "effects",
    "friction",
    "peaks",
    "plan",
    "read_tables",
    "read_uff",
]
