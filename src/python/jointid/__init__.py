"""Joint stiffness and damping of ball-screw feed drives from hammer tests, and what their models lack.

>>> import jointid as jd
>>> study = jd.Study().choose_fit(["l1", "l3", "l5"])    # the published bench; jd.Study("axis/machine.toml", "axis/frfs") for your own
>>> found = study.identify(seed=1)
>>> found.parameters["k_n"].unit
'N/m'
>>> study.without("rotor-hold").diagnose(effects=["rotor-hold"]).verdict.kind
'effect'

Quantities are in SI units, frequencies in Hz; FRFs are response over force with e^{+iωt}.

The examples of this package name, beside these two, `taps` (FRFs of that bench at the positions p1, p2, p3, as a MeasurementSet), `of_taps` (its
identification), `diagnosis` (of `study` without the rotor hold), `machine` (`jd.Machine("configs/tian.toml")`), `drive` (`jd.Machine("configs/emps.toml")`),
`fleet` (two machines, identified), and `np` (NumPy).
"""

from ._processor import load as _load

_load()

from ._core import __version__  # noqa: E402
from ._errors import InputError, StoppedError, shorten_tracebacks as _shorten_tracebacks  # noqa: E402
from ._settings import Settings  # noqa: E402
from .diagnosis import Diagnosis, Effect, Verdict  # noqa: E402
from .fleet import Fleet, FleetRun  # noqa: E402
from .identification import Identification  # noqa: E402
from .machine import Machine, MachineParameter  # noqa: E402
from .measurement import Frf, MeasurementSet  # noqa: E402
from .parameters import Draws, Parameter, Parameters  # noqa: E402
from .readers import read_tables, read_uff  # noqa: E402
from .results import (  # noqa: E402
    Band,
    Comparison,
    Document,
    Friction,
    Peaks,
    Plan,
    Prediction,
    Validation,
)
from .simulation import Modes, Motion, MotionSettings  # noqa: E402
from .standalone import effects, friction, peaks, plan  # noqa: E402
from .study import Study  # noqa: E402
from .trials import blind_check, coverage  # noqa: E402

__all__ = [
    "Band",
    "Comparison",
    "Diagnosis",
    "Document",
    "Draws",
    "Effect",
    "Fleet",
    "FleetRun",
    "Frf",
    "Friction",
    "Identification",
    "InputError",
    "Machine",
    "MachineParameter",
    "MeasurementSet",
    "Modes",
    "Motion",
    "MotionSettings",
    "Parameter",
    "Parameters",
    "Peaks",
    "Plan",
    "Prediction",
    "Settings",
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

globals().update(zip(__all__, _shorten_tracebacks([globals()[name] for name in __all__]), strict=True))
