"""What a machine does by its description alone: modes and motions as arrays."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from . import _arrays, _core, _html
from ._errors import argument
from ._frf import places
from ._optional import pandas_for
from ._progress import Callback, progress_of, running_of
from .results import Document

if TYPE_CHECKING:
    import pandas


class Modes(Document):
    """Undamped modes of a machine.

    >>> modes = machine.modes(nut_m=0.9, max_hz=300.0)
    >>> modes.shapes.shape == (modes.frequency_hz.size, len(modes.points))
    True
    """

    def __init__(self, text: str, units: Mapping[str, str]) -> None:
        super().__init__(text)
        self._units = dict(units)

    @property
    def points(self) -> list[str]:
        """Points that move, in the order of the columns of `shapes`."""
        return list(self._units)

    @property
    def units(self) -> dict[str, str]:
        """Unit of the displacement of each point: m or rad."""
        return self._units

    @cached_property
    def frequency_hz(self) -> NDArray[np.float64]:
        """Natural frequencies (modes,) in Hz; 0 for a rigid-body mode."""
        return np.array([mode["frequency_hz"] for mode in self.document["modes"]], dtype=float)

    @cached_property
    def damping_ratio(self) -> NDArray[np.float64]:
        """Damping ratios (modes,), to first order (1); NaN for rigid-body modes."""
        ratios = [mode["damping_ratio"] for mode in self.document["modes"]]
        return np.array([np.nan if ratio is None else ratio for ratio in ratios], dtype=float)

    @cached_property
    def shapes(self) -> NDArray[np.float64]:
        """Mode shapes (modes, points): deflection of each point in its unit, relative to the largest."""
        rows = [[mode["shape"][point] for point in self.points] for mode in self.document["modes"]]
        return np.array(rows, dtype=float).reshape(-1, len(self.points))

    def mac(self, other: Modes | None = None) -> NDArray[np.float64]:
        """Modal assurance criterion (modes, other's modes): squared cosine of the angle between two shapes, over the points of unit m in both.

        >>> bool(np.allclose(machine.modes().mac().diagonal(), 1.0))
        True

        Raises
        ------
        InputError
            The two have no point in common whose displacement is in m.
        """
        of = self if other is None else other
        shared = [
            point for point, unit in self._units.items() if unit == "m" and of._units.get(point) == "m"
        ]
        if not shared:
            raise argument("other", "shares no point of unit m with these modes; give modes of a like machine")
        own, theirs = (
            modes.shapes[:, [modes.points.index(point) for point in shared]] for modes in (self, of)
        )
        lengths = np.outer((own**2).sum(axis=1), (theirs**2).sum(axis=1))
        # A shape without deflection at these points resembles none.
        return np.divide((own @ theirs.T) ** 2, lengths, out=np.zeros_like(lengths), where=lengths > 0)

    def to_frame(self) -> pandas.DataFrame:
        """One row a mode: frequency, damping ratio, and the deflection of every point.

        >>> machine.modes().to_frame().index.name
        'order'
        """
        table = pandas_for("a table").DataFrame(self.shapes, columns=self.points)
        table.insert(0, "damping_ratio", self.damping_ratio)
        table.insert(0, "frequency_hz", self.frequency_hz)
        return table.set_index(table.index + 1).rename_axis("order")

    def _parts(self) -> list[str]:
        rows = [
            (str(mode["order"]), f"{mode['frequency_hz']:.5g}", f"{100 * (mode['damping_ratio'] or 0):.3g} %")
            for mode in self.document["modes"]
        ]
        return [_html.table(("order", "natural frequency  Hz", "damping ratio"), rows)]

    def __reduce__(self) -> tuple[Any, ...]:
        return Modes, (self.json, self._units)


class Motion(Document):
    """A simulated motion: signals as arrays of one length.

    >>> motion = drive.simulate_motion(sine=(0.01, 2.0, 3.0))
    >>> motion["time_s"].shape == motion["force_n"].shape
    True
    """

    @cached_property
    def signals(self) -> dict[str, NDArray[np.float64]]:
        """Signals by name, such as `time_s`, `command_m`, `position_m`, `velocity_m_s`, `force_n`, and one for each point that moves."""
        return {name: np.array(column, dtype=float) for name, column in self.document["columns"].items()}

    @property
    def is_stable(self) -> bool:
        """Whether the motion stayed near its command to the end."""
        return self.document.get("unstable") is None

    def __getitem__(self, key: str) -> Any:
        return self.signals[key] if key in self.document["columns"] else self.document[key]

    def to_frame(self) -> pandas.DataFrame:
        """One row a sample.

        >>> len(drive.simulate_motion(travel_m=0.01).to_frame()) > 100
        True
        """
        return pandas_for("a table").DataFrame(self.signals)

    def _parts(self) -> list[str]:
        rows = [
            (name, f"{column.min():.4g}", f"{column.max():.4g}")
            for name, column in self.signals.items()
            if column.size
        ]
        return [_html.table(("signal", "least", "largest"), rows)]


def modes_of(core: _core.Study, nut_m: Any, position: Any, max_hz: Any) -> Modes:
    """Modes of a machine at its start values; mid-stroke where no place is given."""
    at = None if nut_m is None else _arrays.number("nut_m", nut_m, "give a distance in m")
    text = core.modes(at, _arrays.optional_name("position", position), _arrays.number("max_hz", max_hz))
    # Names that begin with ~ are the model's own.
    return Modes(text, {point: unit for point, unit in core.units if not point.startswith("~")})


def stiffness_of(core: _core.Study, point: Any, nut_m: Any, positions: Any) -> NDArray[np.float64]:
    """Static stiffness of a point of a machine at its start values."""
    nuts, names = places(nut_m, positions)
    values = np.array(core.static_stiffness(_arrays.name("point", point), nuts, names))
    single = names is None and np.ndim(nut_m) == 0
    return values[0] if single or isinstance(positions, str) else values


class MotionSettings(TypedDict, total=False):
    """The command of a simulated motion; rad replaces m where the encoder of the axis reads an angle.

    travel_m, velocity_m_s, acceleration_m_s2, jerk_m_s3, rest_s : float
        Travel from rest to rest with its limits, and rest before and after in s (0.1, 0.2, 2, 50, 0.2).
    and_back : bool
        Whether the axis returns.
    sine : (float, float, float)
        Amplitude (m), frequency (Hz) and number of periods of a sine instead, whose amplitude rises over the first period.
    table : path
        A table with the columns `time_s` and `command_m` instead.
    nut_m : float
        Nut position at the start (m); mid-stroke by default.
    lumps : int
        Springs per rod (4).
    step_s : float
        Longest time step (s); the period of the innermost loop by default.

    >>> settings: jd.MotionSettings = {"travel_m": 0.02, "and_back": True}
    >>> drive.simulate_motion(**settings).complete
    True
    """

    travel_m: float
    velocity_m_s: float
    acceleration_m_s2: float
    jerk_m_s3: float
    rest_s: float
    and_back: bool
    sine: tuple[float, float, float]
    table: str | os.PathLike[str]
    nut_m: float
    lumps: int
    step_s: float


# The travel where none is stated, as the command has it.
_TRAVEL = {"travel_m": 0.1, "velocity_m_s": 0.2, "acceleration_m_s2": 2.0, "jerk_m_s3": 50.0, "rest_s": 0.2}


def _sine(given: Any) -> tuple[float, ...]:
    if np.shape(given) != (3,):
        raise argument("sine", f"is {given!r}; give amplitude (m), frequency (Hz) and number of periods")
    return tuple(_arrays.number(f"sine[{at}]", number) for at, number in enumerate(given))


def motion_of(
    core: _core.Study,
    given: Mapping[str, Any],
    named: tuple[Any, Any],
    threads: int | None,
    progress: bool | Callback | None,
) -> Motion:
    """Simulates the motion of a machine's drive at its start values; `named` are a record and a position of a measurement set."""
    _arrays.unknown("motion", given, MotionSettings.__annotations__)
    record, position = (
        _arrays.optional_name(key, name) for key, name in zip(("record", "position"), named, strict=True)
    )
    stated = dict(given) | ({} if record is None else {"record": record})
    references = [key for key in ("sine", "table", "record") if stated.get(key) is not None]
    if len(references) > 1:
        raise argument(references[1], f"is given beside {references[0]}; give one of them")

    def checked(key: str, check: Callable[[str, Any], Any]) -> Any:
        return None if stated.get(key) is None else check(key, stated[key])

    request = {
        "travel": tuple(_arrays.number(key, stated.get(key, usual)) for key, usual in _TRAVEL.items()),
        "and_back": bool(stated.get("and_back", False)),
        "sine": checked("sine", lambda _, sine: _sine(sine)),
        "table": checked("table", _arrays.path),
        "record": record,
        "nut_m": checked("nut_m", _arrays.number),
        "position": position,
        "lumps": checked("lumps", lambda key, count: _arrays.count(key, count, 1)),
        "step_s": checked("step_s", _arrays.number),
    }
    with progress_of(progress, "motion") as callback:
        return Motion(core.motion(request, running_of(callback, threads)))
