"""Results: the documents of the command, with their main rows as dataclasses."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _arrays, _core
from ._errors import needs
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
    for a parameter that was not fitted, or whose value depends on what `depends_on` lists (`depends_on_discrepancy`).
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
    depends_on: tuple[str, ...] = ()

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
            depends_on=tuple(row.get("depends_on", ())),
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
            row = {
                "parameter": name,
                "value": parameter.value,
                "unit": parameter.unit,
                "interval_low": low,
                "interval_high": high,
            }
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
            (
                name,
                Parameter(
                    row["value"],
                    row["unit"],
                    0.0,
                    inf,
                    _interval(row["interval95"]),
                    not row["at_bound"],
                    True,
                ),
            )
            for name, row in rows
        )


class Plan(Document):
    """Choices of measurements, ranked by what they decide."""

    @property
    def best(self) -> list[str]:
        """The best choice of the first ranking."""
        return self.document["rankings"][0]["choices"][0]["measure"]


@dataclass(frozen=True)
class Draws:
    """Machines that the data leave possible.

    Attributes
    ----------
    parameters : list of str
        Ids of parameters, and names of tolerances.
    values : (draws, parameters) array
        Their values, each in its unit.
    minimum : (draws,) array
        Number of the minimum about which a machine was drawn, from 0, the best.
    weight : (draws,) array
        Likelihood of that minimum over that of the best, exp(−Δχ²/2): 1 for draws about the best.
    """

    parameters: list[str]
    values: NDArray[np.float64]
    minimum: NDArray[np.int64]
    weight: NDArray[np.float64]

    def to_frame(self) -> pandas.DataFrame:
        """One row a draw: minimum, weight, and the value of every parameter."""
        table = _pandas("a table").DataFrame(self.values, columns=self.parameters)
        table.insert(0, "weight", self.weight)
        table.insert(0, "minimum", self.minimum)
        return table


class Prediction(Document):
    """Natural modes, and FRFs where asked for, of an identified machine at places of the nut, with 95 % intervals."""

    @property
    def positions(self) -> dict[str, dict[str, Any]]:
        """Predictions by position, or nut position as text."""
        return self.document["positions"]

    def to_frame(self) -> pandas.DataFrame:
        """One row a mode: position, nut_m, order, frequency of the peak, undamped natural frequency, damping ratio and amplitude with their intervals."""
        rows = []
        for name, place in self.positions.items():
            for mode in place["modes"]:
                row = {"position": name, "nut_m": place["nut_m"], "order": mode["order"]}
                for key, ends in (
                    ("frequency_hz", "frequency95"),
                    ("natural_hz", "natural95"),
                    ("damping_ratio", "damping95"),
                    ("amplitude", "amplitude95"),
                ):
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
        return np.array(
            poles, dtype=[("order", int), ("frequency_hz", float), ("damping_ratio", float), ("stable", bool)]
        )

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
        return Verdict(
            row["kind"], effects, row["reason"], row.get("next_measurement"), faults, row.get("confirmed")
        )

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
