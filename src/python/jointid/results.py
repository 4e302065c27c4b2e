"""Results: the documents of the command, with their main rows as dataclasses."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _arrays, _core, _html
from ._optional import optional, pandas_for
from .measurement import MeasurementSet, write
from .parameters import Parameter, Parameters, interval_of

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100 * share:.2f} %"


def measured(value: float | None, ends: Sequence[float] | None) -> tuple[str, str]:
    """A value and its interval as text."""
    return "–" if value is None else f"{value:.4g}", f"{ends[0]:.4g} … {ends[1]:.4g}" if ends else ""


class Document(Mapping[str, Any]):
    """A result document, as the command prints it with `--json`: a mapping of its keys. Pickles as its JSON text.

    >>> found["schema"]
    'jointid/identification/1'
    """

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

    def save(self, path: str | os.PathLike[str], *, replace: bool = False) -> None:
        """Writes the document as a JSON file, which the command reads. A file that jointid did not write stays, unless `replace` is given.

        >>> found.validate().save("validation.json")
        """
        write(path, self.json, replace=replace)

    def to_mat(self, path: str | os.PathLike[str], *, replace: bool = False) -> None:
        """Writes the document as a MATLAB file (version 5): one struct, with lists of numbers as arrays and absent values as [].

        Names that MATLAB does not allow are changed: `l1:table/table` becomes `l1_table_table`.

        >>> found.to_mat("found.mat")
        """
        from ._mat import to_mat

        to_mat(path, type(self).__name__.lower(), self.document, replace=replace)

    def report(self, path: str | os.PathLike[str], *others: Document, replace: bool = False) -> list[str]:
        """Writes a page (HTML) of the document, and of `others` of the same machine; it is one file that works offline.

        Returns what the page does not draw, and why.

        >>> found.report("report.html", found.validate())
        []
        """
        from ._report import report

        return report(path, [self, *others], replace=replace)

    def __getitem__(self, key: str) -> Any:
        return self.document[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.document)

    def __len__(self) -> int:
        return len(self.document)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.json,)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}, {self.document['schema']}>"

    def _repr_html_(self) -> str:
        return _html.page(type(self).__name__, self.document["schema"], self._parts(), self.warnings)

    def _parts(self) -> list[str]:
        """Parts of the document as HTML."""
        return []


class Validation(Document):
    """Prediction errors at held-out positions or records.

    >>> found.validate().largest_error < 0.03
    True
    """

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

    def _parts(self) -> list[str]:
        rows = [(name, _percent(error)) for name, error in self.overall_error.items()]
        return [_html.table(("position", "overall error"), rows)]


class Comparison(Document):
    """A multi-position identification beside single-position ones.

    >>> comparison = study.compare(["l3"])
    >>> comparison.common_error["multi"] < comparison.common_error["l3"]
    True
    """

    @property
    def common_error(self) -> dict[str, float | None]:
        """Error of each run at the positions held out of all (1)."""
        return {name: run["common_error"] for name, run in self.document["runs"].items()}

    def _parts(self) -> list[str]:
        rows = [(name, _percent(error)) for name, error in self.common_error.items()]
        return [_html.table(("run", "error at the positions held out of all"), rows)]


class Friction(Document):
    """A Stribeck curve, fitted to friction at constant velocities.

    >>> sorted(jd.friction(friction_table).parameters)[0]
    'coulomb_n'
    """

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
                    interval_of(row["interval95"]),
                    not row["at_bound"],
                    True,
                ),
            )
            for name, row in rows
        )


class Plan(Document):
    """Choices of measurements, ranked by what they decide.

    >>> len(study.plan(choose=2).best)
    2
    """

    @property
    def best(self) -> list[str]:
        """The best choice of the first ranking."""
        return self.document["rankings"][0]["choices"][0]["measure"]

    def _parts(self) -> list[str]:
        return [_html.pairs({"best choice": ", ".join(self.best)})]


class Band(NamedTuple):
    """A predicted FRF: frequencies (Hz), values, and ends of the pointwise 95 % interval of their magnitude.

    >>> band = of_taps.predict(nut_m=0.9, frequency_hz=[50.0, 100.0]).bands["0.9"]
    >>> bool((band.low <= band.high).all())
    True
    """

    frequency_hz: NDArray[np.float64]
    value: NDArray[np.complex128]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


class Prediction(Document):
    """Natural modes, and FRFs where asked for, of an identified machine at places of the nut, with 95 % intervals.

    >>> list(found.predict(nut_m=[0.5, 0.9]).positions)
    ['0.5', '0.9']
    """

    @property
    def positions(self) -> dict[str, dict[str, Any]]:
        """Predictions by position, or nut position as text."""
        return self.document["positions"]

    @property
    def bands(self) -> dict[str, Band]:
        """Predicted FRFs with their 95 % intervals, by position; empty where none were asked for."""
        found = {}
        for name, place in self.positions.items():
            if (frf := place.get("frf")) is not None:
                real, imag = np.array(frf["value"], dtype=float).T
                low, high = np.array(frf["magnitude95"], dtype=float).T
                found[name] = Band(np.array(frf["frequency_hz"], dtype=float), real + 1j * imag, low, high)
        return found

    def to_xarray(self) -> Any:
        """The prediction as a Dataset of xarray: modes over position and order, FRFs over position and `line_hz`; `_low` and `_high` are the ends of
        95 % intervals.

        >>> of_taps.predict(nut_m=[0.7, 0.9], frequency_hz=[50.0, 100.0]).to_xarray()["frf"].dims
        ('position', 'line_hz')
        """
        optional("xarray", "xarray", "a Dataset")
        modes = self.to_frame().set_index(["position", "order"]).drop(columns="nut_m").to_xarray()
        places = list(self.positions)
        made = modes.sel(position=places).assign_coords(
            nut_m=("position", [self.positions[name]["nut_m"] for name in places])
        )
        bands = list(self.bands.values())
        if bands:
            columns = {"frf": "value", "magnitude_low": "low", "magnitude_high": "high"}
            made = made.assign_coords(line_hz=bands[0].frequency_hz).assign(
                {
                    name: (("position", "line_hz"), np.stack([getattr(band, field) for band in bands]))
                    for name, field in columns.items()
                }
            )
        return made

    def to_frame(self) -> pandas.DataFrame:
        """One row a mode: position, nut_m, order, frequency of the peak, undamped natural frequency, damping ratio and amplitude with their intervals.

        >>> found.predict(nut_m=0.9).to_frame()["frequency_hz"].is_monotonic_increasing
        True
        """
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
        return pandas_for("a table").DataFrame(rows)

    def plot(self, *, ax: Axes | Any = None) -> Figure:
        """Draws natural frequencies over the nut position, with their intervals; `ax` is one axes for each order.

        >>> figure = found.predict(nut_m=[0.5, 0.9]).plot()
        """
        from . import plot

        return plot.prediction(self, ax)

    def _parts(self) -> list[str]:
        rows = [
            (name, str(mode["order"]), *measured(mode["frequency_hz"], mode["frequency95"]))
            for name, place in self.positions.items()
            for mode in place["modes"]
        ]
        return [_html.table(("position", "order", "peak  Hz", "95 % interval"), rows)]


class Peaks(Document):
    """Natural frequencies from FRFs, tracked over the positions; :func:`jointid.peaks` finds them.

    >>> [mode["order"] for mode in jd.peaks(taps)["modes"]][:1]
    [1]
    """

    def __init__(self, text: str, modes_csv: str, measurements: MeasurementSet) -> None:
        super().__init__(text)
        self.modes_csv, self._measurements = modes_csv, measurements

    def to_frame(self) -> pandas.DataFrame:
        """One row a mode and record: order, regular, record, natural frequency, damping ratio and amplitude with standard deviations.

        >>> "damping_ratio" in jd.peaks(taps).to_frame()
        True
        """
        rows = [
            {"order": mode["order"], "regular": mode["regular"], "record": record} | row
            for mode in self.document["modes"]
            for record, row in mode["records"].items()
        ]
        return pandas_for("a table").DataFrame(rows)

    def stabilisation(self, record: str | None = None, max_order: int | None = None) -> NDArray[Any]:
        """Stabilisation diagram of an FRF (the first by default): an array with the fields `order`, `frequency_hz`, `damping_ratio`, `stable`.

        >>> jd.peaks(taps).stabilisation("p1").dtype.names
        ('order', 'frequency_hz', 'damping_ratio', 'stable')
        """
        names = list(self._measurements.frfs)
        wanted = names[0] if record is None else _arrays.name("record", record)
        _arrays.unknown("record", [wanted], names)
        order = _arrays.optional_count("max_order", max_order, 8)
        poles = _core.stabilisation(self._measurements._core, names.index(wanted), order)
        return np.array(
            poles, dtype=[("order", int), ("frequency_hz", float), ("damping_ratio", float), ("stable", bool)]
        )

    def plot(self, record: str | None = None, *, ax: Axes | None = None) -> Figure:
        """Draws the stabilisation diagram of an FRF over its magnitude, with the regular modes.

        >>> figure = jd.peaks(taps).plot("p1")
        """
        from . import plot

        return plot.stabilisation(self, record, ax)

    def _parts(self) -> list[str]:
        rows = [
            (str(mode["order"]), record, f"{row['frequency_hz']:.5g}", f"{100 * row['damping_ratio']:.3g} %")
            for mode in self.document["modes"]
            if mode["regular"]
            for record, row in mode["records"].items()
        ]
        return [_html.table(("order", "record", "natural frequency  Hz", "damping ratio"), rows)]

    def __reduce__(self) -> tuple[Any, ...]:
        return Peaks, (self.json, self.modes_csv, self._measurements)
