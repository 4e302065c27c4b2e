"""Results: the documents of the command, with their main rows as dataclasses."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _core
from ._errors import InputError, argument, needs
from ._progress import Callback, progress_of
from .machine import Machine
from .measurement import MeasurementSet, write

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

    from .study import Study

Interval = tuple[float, float]


@dataclass(frozen=True)
class Parameter:
    """An identified parameter, in `unit`.

    `interval95` is the 95 % interval (None where none was computed), `intervals95` its parts where the data accept several ranges. `identifiable` is None
    for a parameter that was not fitted, or whose value depends on what the model lacks (`depends_on_discrepancy`).
    """

    value: float
    unit: str
    lower: float
    upper: float
    interval95: Interval | None
    identifiable: bool | None
    fitted: bool
    depends_on_discrepancy: bool = False
    intervals95: tuple[Interval, ...] = ()
    description: str = ""

    @classmethod
    def _of(cls, row: Mapping[str, Any]) -> Parameter:
        return cls(
            value=row["value"],
            unit=row["unit"],
            lower=row["lower"],
            upper=row["upper"],
            interval95=_interval(row.get("interval95")),
            identifiable=row.get("identifiable"),
            fitted=row["fitted"],
            depends_on_discrepancy=row.get("depends_on_discrepancy", False),
            intervals95=tuple((low, high) for low, high in row.get("intervals95", ())),
            description=row.get("description", ""),
        )


class Parameters(dict[str, Parameter]):
    """Parameters by id."""

    def to_frame(self) -> pandas.DataFrame:
        """One row a parameter: value, unit, interval_low, interval_high, identifiable, …"""
        rows = []
        for name, parameter in self.items():
            low, high = parameter.interval95 or (None, None)
            keys = ("identifiable", "depends_on_discrepancy", "fitted", "lower", "upper", "description")
            row = {"parameter": name, "value": parameter.value, "unit": parameter.unit, "interval_low": low, "interval_high": high}
            rows.append(row | {key: getattr(parameter, key) for key in keys})
        return _pandas("a table").DataFrame(rows).set_index("parameter")


@dataclass(frozen=True)
class Effect:
    """A candidate effect of a diagnosis; `closed` is the share of the squared held-out gap above the noise floor that it closes.

    `open`: its best fit was found by a single search, so that a deeper minimum may exist.
    """

    id: str
    status: str
    closed: float | None
    closed95: Interval | None
    p_value: float | None
    gap_held_out_before: float | None
    gap_held_out_after: float | None
    parameters: Mapping[str, float]
    selected: bool
    description: str | None
    open: bool


@dataclass(frozen=True)
class Verdict:
    """The verdict of a diagnosis: its kind, the effects or faults that it names, why, and whether held-out data confirm it (None: nothing is held out)."""

    kind: str
    effects: tuple[str, ...]
    reason: str
    next_measurement: str | None
    faults: tuple[str, ...]
    confirmed: bool | None


def _interval(ends: Sequence[float] | None) -> Interval | None:
    return None if ends is None else (ends[0], ends[1])


def _pandas(purpose: str) -> Any:
    try:
        import pandas
    except ImportError:
        raise needs("pandas", "pandas", purpose) from None
    return pandas


class Document(Mapping[str, Any]):
    """A result document, as the command prints it with `--json`: a mapping of its keys. Pickles as its JSON text."""

    def __init__(self, text: str) -> None:
        self._json = text

    @property
    def json(self) -> str:
        """The document as JSON text."""
        return self._json

    @cached_property
    def document(self) -> dict[str, Any]:
        """The document as a dictionary."""
        return json.loads(self.json)

    @property
    def warnings(self) -> list[str]:
        """Warnings, one sentence each."""
        return self.document.get("warnings", [])

    @property
    def complete(self) -> bool:
        """Whether the work ran to its end."""
        return self.document["complete"]

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the document as a JSON file, which the command reads."""
        write(path, self.json)

    def to_mat(self, path: str | os.PathLike[str]) -> None:
        """Writes the document as a MATLAB file (version 5): one struct, with lists of numbers as arrays and absent values as [].

        Names that MATLAB does not allow are changed: `l1:table/table` becomes `l1_table_table`.
        """
        from ._mat import to_mat

        to_mat(path, type(self).__name__.lower(), self.document)

    def __getitem__(self, key: str) -> Any:
        return self.document[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.document)

    def __len__(self) -> int:
        return len(self.document)

    def __reduce__(self):
        return type(self), (self.json,)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}, {self.document['schema']}>"


class Validation(Document):
    """Prediction errors at held-out positions or records."""

    @property
    def largest_error(self) -> float | None:
        """Largest relative frequency error (1)."""
        return self.document["largest_error"]

    @property
    def largest_gap(self) -> float | None:
        """Largest gap of a position or record (1), for FRFs and motion records."""
        return self.document.get("largest_gap")

    @property
    def overall_error(self) -> dict[str, float | None]:
        """Root sum of squares of the relative frequency errors by position (1)."""
        return {name: row["overall_error"] for name, row in self.document["positions"].items()}


class Comparison(Document):
    """A multi-position identification beside single-position ones."""

    @property
    def common_error(self) -> dict[str, float | None]:
        """Error of each run at the positions held out of all (1)."""
        return {name: run["common_error"] for name, run in self.document["runs"].items()}


class Friction(Document):
    """A Stribeck curve, fitted to friction at constant velocities."""

    @property
    def parameters(self) -> Parameters:
        """Parameters by id."""
        rows = self.document["parameters"].items()
        inf = float("inf")
        return Parameters(
            (name, Parameter(row["value"], row["unit"], 0.0, inf, _interval(row["interval95"]), not row["at_bound"], True)) for name, row in rows
        )


class Plan(Document):
    """Choices of measurements, ranked by what they decide."""

    @property
    def best(self) -> list[str]:
        """The best choice of the first ranking."""
        return self.document["plans"][0]["choices"][0]["measurements"]


class Prediction(Document):
    """Natural modes, and FRFs where asked for, of an identified machine at places of the nut, with 95 % intervals."""

    @property
    def positions(self) -> dict[str, dict[str, Any]]:
        """Predictions by position, or nut position as text."""
        return self.document["positions"]

    def to_frame(self) -> pandas.DataFrame:
        """One row a mode: position, nut_m, order, frequency, damping ratio and amplitude with their intervals."""
        rows = []
        for name, place in self.positions.items():
            for mode in place["modes"]:
                row = {"position": name, "nut_m": place["nut_m"], "order": mode["order"]}
                for key, ends in (("frequency_hz", "frequency95"), ("damping_ratio", "damping95"), ("amplitude", "amplitude95")):
                    low, high = mode[ends] or (None, None)
                    row |= {key: mode[key], f"{key}_low": low, f"{key}_high": high}
                rows.append(row)
        return _pandas("a table").DataFrame(rows)

    def plot(self) -> Figure:
        """Natural frequencies over the nut position, with their intervals."""
        from . import plot

        return plot.prediction(self)


class Peaks(Document):
    """Natural frequencies from FRFs, tracked over the positions."""

    def __init__(self, text: str, modes_csv: str, measurements: MeasurementSet) -> None:
        super().__init__(text)
        self.modes_csv, self._measurements = modes_csv, measurements

    def to_frame(self) -> pandas.DataFrame:
        """One row a mode and record: order, regular, record, natural frequency, damping ratio and amplitude with standard deviations."""
        rows = [
            {"order": mode["order"], "regular": mode["regular"], "record": record} | row
            for mode in self.document["modes"]
            for record, row in mode["records"].items()
        ]
        return _pandas("a table").DataFrame(rows)

    def stabilisation(self, record: str | None = None, max_order: int | None = None) -> NDArray[Any]:
        """Stabilisation diagram of an FRF (the first by default): an array with the fields `order`, `frequency_hz`, `damping_ratio`, `stable`."""
        names = list(self._measurements.frfs)
        wanted = names[0] if record is None else _arrays.name("record", record)
        _arrays.unknown("record", [wanted], names)
        order = _arrays.optional_count("max_order", max_order, 8)
        poles = _core.stabilisation(self._measurements._core, names.index(wanted), order)
        return np.array(poles, dtype=[("order", int), ("frequency_hz", float), ("damping_ratio", float), ("stable", bool)])

    def plot(self, record: str | None = None) -> Figure:
        """Stabilisation diagram of an FRF over its magnitude, with the regular modes."""
        from . import plot

        return plot.stabilisation(self, record)

    def __reduce__(self):
        return Peaks, (self.json, self.modes_csv, self._measurements)


class Diagnosis(Document):
    """Where model and machine disagree, which effect the model lacks, and how far including it closes the gap."""

    def __init__(self, text: str, study: Study) -> None:
        super().__init__(text)
        self.study = study

    @cached_property
    def verdict(self) -> Verdict:
        """The verdict."""
        row = self.document["verdict"]
        faults, effects = tuple(row.get("faults", ())), tuple(row["effects"])
        return Verdict(row["kind"], effects, row["reason"], row.get("next_measurement"), faults, row.get("confirmed"))

    @cached_property
    def effects(self) -> dict[str, Effect]:
        """All candidates by id, best first."""
        return {
            row["id"]: Effect(
                id=row["id"],
                status=row["status"],
                closed=row["closed"],
                closed95=_interval(row.get("closed95")),
                p_value=row["p_value"],
                gap_held_out_before=row["gap_held_out_before"],
                gap_held_out_after=row["gap_held_out_after"],
                parameters=row["parameters"],
                selected=row["selected"],
                description=row.get("description"),
                open=row.get("open", False),
            )
            for row in self.document["effects"]
        }

    @property
    def where(self) -> list[dict[str, Any]]:
        """Locations of the discrepancy, best first."""
        return self.document["where"]

    @property
    def gap(self) -> dict[str, Any]:
        """Gaps of the machine as described."""
        return self.document["gap"]

    def apply(self) -> Study:
        """Returns the study of the machine with the effect that the verdict names.

        Raises
        ------
        InputError
            The verdict names no effect, or more than one explanation.
        """
        text = self.study._core.machine_of_diagnosis(self.json)
        return self.study.with_machine(Machine.from_text(text, self.study.machine.path))

    def to_frame(self) -> pandas.DataFrame:
        """One row a candidate that was tried, best first."""
        tried = [vars(effect) for effect in self.effects.values() if effect.status == "tried"]
        return _pandas("a table").DataFrame(tried).set_index("id")

    def plot(self) -> Figure:
        """Map of where the gap lies (position by band), and the share that each candidate closes."""
        from . import plot

        return plot.diagnosis(self)

    def __reduce__(self):
        return Diagnosis, (self.json, self.study)

    def __repr__(self) -> str:
        names = " or ".join(self.verdict.effects) or "–"
        return f"<Diagnosis: {self.verdict.kind}, {names}: {self.verdict.reason}>"


class Identification(Document):
    """An identified machine: parameters with intervals, predictions, FRFs."""

    def __init__(self, core: _core.Identification, study: Study) -> None:
        self._core, self.study = core, study

    @cached_property
    def json(self) -> str:
        """The document as JSON text."""
        return self._core.json()

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Identification:
        """Reads an `identification.json`, with its machine, measurement set and split.

        Raises
        ------
        InputError
            The file is no identification, or its measurement set cannot be read.
        """
        from .study import study_of_document

        file = _arrays.path("path", path)
        try:
            with open(file, encoding="utf-8") as opened:
                text = opened.read()
            study = study_of_document(json.loads(text))
        except OSError as fault:
            raise InputError(f"{file}: cannot be read ({fault.strerror or fault})", file=file, key="path") from None
        except (ValueError, KeyError, TypeError) as fault:
            if isinstance(fault, InputError):
                raise
            raise InputError(f"{file}: is no identification.json ({fault}); name the file that identify has written", file=file) from None
        return cls(study._core.identification(text), study)

    @cached_property
    def parameters(self) -> Parameters:
        """Estimates by parameter id."""
        return Parameters((name, Parameter._of(row)) for name, row in self.document["parameters"].items())

    @property
    def interval95(self) -> dict[str, Interval | None]:
        """95 % intervals by parameter id."""
        return {name: parameter.interval95 for name, parameter in self.parameters.items()}

    @property
    def derived(self) -> dict[str, float]:
        """Derived quantities by name: those of the machine's description, largest errors and gaps, χ² and its degrees of freedom."""
        return self.document["derived"]

    @property
    def cost(self) -> float:
        """Minimum of the objective (1): χ² of modes and FRFs."""
        return self.document["cost"]

    @property
    def overall_error(self) -> dict[str, float | None]:
        """Root sum of squares of the relative frequency errors by position (1)."""
        return {name: row["overall_error"] for name, row in self.document["positions"].items()}

    def frf(
        self,
        frequency_hz: ArrayLike,
        *,
        nut_m: float | Sequence[float] | None = None,
        positions: str | Sequence[str] | None = None,
        response: str | None = None,
        excitation: str | None = None,
        quantity: str | None = None,
        closed_loop: bool = False,
    ) -> NDArray[np.complex128]:
        """Computes FRFs of the identified machine, H = response / force with e^{+iωt}.

        Parameters
        ----------
        frequency_hz : (lines,) array
            Frequencies in Hz, above 0.
        nut_m : float or (places,) sequence
            Nut positions from the left end of the screw (m).
        positions : str or list of str
            Positions of the measurement set instead; all of them where neither is given.
        response, excitation : str
            Points of the machine; those of the measurement set where absent.
        quantity : {"receptance", "mobility", "accelerance"}
            In m/N, (m/s)/N or (m/s²)/N; that of the measurement set where absent.
        closed_loop : bool
            Whether the loops of the drive are closed.

        Returns
        -------
        (places, lines) array of complex numbers; (lines,) for one nut position or name.

        Raises
        ------
        InputError
            A place is outside the screw, a point is unknown, a frequency is not above 0.
        """
        return frf_of(self._core, self.study, frequency_hz, nut_m, positions, response, excitation, quantity, closed_loop)

    def predict(
        self,
        *,
        nut_m: float | Sequence[float] | None = None,
        positions: str | Sequence[str] | None = None,
        frf: bool = False,
        frequency_hz: ArrayLike | None = None,
        band_hz: Interval | None = None,
        draws: int | None = None,
        seed: int = 1,
        threads: int | None = None,
        progress: bool | Callback | None = None,
    ) -> Prediction:
        """Predicts natural modes and static stiffness with 95 % intervals, and FRFs with a pointwise band where `frf` is asked for.

        `nut_m` are nut positions (m), `positions` names of the measurement set (all of them where neither is given); `draws` machines are drawn from what
        data and tolerances leave possible (199 by default).
        """
        nuts, names = _places(nut_m, positions)
        lines = None if frequency_hz is None else _arrays.frequencies("frequency_hz", frequency_hz).tolist()
        with progress_of(progress, "predict") as callback:
            running = {"progress": callback, "threads": _arrays.optional_count("threads", threads, 1)}
            drawn = _arrays.optional_count("draws", draws, 1)
            band = _arrays.band("band_hz", band_hz)
            text = self._core.predict(nuts, names, bool(frf) or lines is not None, lines, band, drawn, _arrays.count("seed", seed), running)
        return Prediction(text)

    def draws(
        self,
        count: int,
        *,
        seed: int = 1,
        bootstrap: bool | None = None,
        threads: int | None = None,
        progress: bool | Callback | None = False,
    ) -> tuple[list[str], NDArray[np.float64]]:
        """Draws machines that the data leave possible: by a bootstrap over lines (the default for FRFs), or from the posterior.

        Returns the ids of parameters and tolerances, and an array (draws, parameters). About each of several minima `count` machines are drawn.
        """
        lines = self.document["settings"]["objective"] == "frf" if bootstrap is None else bool(bootstrap)
        with progress_of(progress, "draw") as callback:
            running = {"progress": callback, "threads": _arrays.optional_count("threads", threads, 1)}
            ids, values = self._core.draws(_arrays.count("count", count, 1), _arrays.count("seed", seed), lines, running)
        return ids, values[1:]

    def validate(
        self, positions: str | Sequence[str] | None = None, *, measurements: MeasurementSet | str | os.PathLike[str] | None = None
    ) -> Validation:
        """Predicts what was held out, the named positions, or another measurement set, and returns the errors."""
        names = None if positions is None else _arrays.names("positions", positions)
        other = measurements if measurements is None or isinstance(measurements, MeasurementSet) else MeasurementSet(measurements)
        return Validation(self._core.validate(names, None if other is None else other._core))

    def machine(self) -> Machine:
        """The machine as identified: parameters start at their estimates, tolerances are held at theirs."""
        return Machine.from_text(self._core.machine(), self.study.machine.path)

    def profile(
        self, parameter: str, points: int | ArrayLike = 9, *, threads: int | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Profile of the objective over a parameter: it is held at each value, and all others are fitted anew.

        `points` is a number of values over 1.5 times the 95 % interval, or the values. Returns values (n,), in the parameter's unit, and costs (n,).
        """
        _arrays.unknown("parameter", [_arrays.name("parameter", parameter)], self.parameters)
        row = self.parameters[parameter]
        if not row.fitted:
            raise argument("parameter", f"«{parameter}» was not fitted; name one that was")
        if np.ndim(points) == 0:
            low, high = row.interval95 or (row.lower, row.upper)
            low, high = max(row.lower, row.value - 1.5 * (row.value - low)), min(row.upper, row.value + 1.5 * (high - row.value))
            ratio = high / low if low > 0 else np.inf
            count = _arrays.count("points", points, 2)
            values = np.geomspace(low, high, count) if 10 < ratio < np.inf else np.linspace(low, high, count)
        else:
            values = _arrays.real_array("points", points)
        costs = [self.study.overridden({f"parameter.{parameter}.start": value})._cost_with_frozen(parameter, threads) for value in values]
        return values, np.array(costs)

    def to_frame(self) -> pandas.DataFrame:
        """The parameters as a table, as :meth:`Parameters.to_frame`."""
        return self.parameters.to_frame()

    def plot(self, positions: str | Sequence[str] | None = None) -> Figure:
        """Measurements with the machine before and after: FRFs, else natural frequencies."""
        from . import plot

        return plot.identification(self, None if positions is None else _arrays.names("positions", positions))

    def plot_profile(self, parameter: str, points: int | ArrayLike = 9) -> Figure:
        """Profile of the objective over a parameter (see :meth:`profile`), with the 95 % interval."""
        from . import plot

        return plot.profile(self, parameter, points)

    def plot_modes(self, *, nut_m: float | None = None, position: str | None = None, max_hz: float = 1000.0) -> Figure:
        """Mode shapes of the identified machine: displacement of every point."""
        from . import plot

        return plot.modes(self, nut_m, position, max_hz)

    def __reduce__(self):
        return _restored, (self.study, self.json)

    def __repr__(self) -> str:
        lines = [f"<Identification of «{self.study.machine.title}», fitted: {', '.join(self.document['fit_positions'])}"]
        for name, row in self.parameters.items():
            interval = f"  {row.interval95[0]:.4g} … {row.interval95[1]:.4g}" if row.interval95 else ""
            known = {True: "identifiable", False: "not identifiable", None: "depends on what the model lacks"}[row.identifiable]
            lines.append(f"  {name} = {row.value:.4g} {row.unit}{interval}{'  ' + known if row.fitted else '  held'}")
        return "\n".join(lines) + ">"


def _restored(study: Study, text: str) -> Identification:
    return Identification(study._core.identification(text), study)


def _places(nut_m: Any, positions: Any) -> tuple[list[float] | None, list[str] | None]:
    if nut_m is not None and positions is not None:
        raise argument("nut_m", "is given beside positions; give one of them")
    nuts = None if nut_m is None else [_arrays.number("nut_m", at, "give distances in m") for at in np.atleast_1d(np.asarray(nut_m, dtype=object))]
    return nuts, None if positions is None else _arrays.names("positions", positions)


def frf_of(
    core: _core.Identification | _core.Study,
    study: Study,
    frequency_hz: Any,
    nut_m: Any,
    positions: Any,
    response: Any,
    excitation: Any,
    quantity: Any,
    closed_loop: bool,
) -> NDArray[np.complex128]:
    """Computes FRFs of a machine at its start values or as identified."""
    lines = _arrays.frequencies("frequency_hz", frequency_hz, rising=False)
    nuts, names = _places(nut_m, positions)
    given = {
        "nut_m": nuts,
        "positions": names,
        "response": _arrays.optional_name("response", response),
        "excitation": _arrays.optional_name("excitation", excitation),
        "quantity": _arrays.optional_name("quantity", quantity) or study.quantity,
        "closed_loop": bool(closed_loop),
    }
    values = core.frf(given, lines)
    single = (nut_m is not None and np.ndim(nut_m) == 0) or isinstance(positions, str)
    return values[0] if single else values
