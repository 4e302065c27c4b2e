"""Identifications: an identified machine with its parameters, predictions and figures."""

from __future__ import annotations

import json
import os
from collections.abc import Callable as Function, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _core, _html
from ._errors import InputError, argument
from ._frf import frf_of, places
from ._progress import Callback, progress_of, running_of
from .machine import Machine
from .measurement import MeasurementSet
from .parameters import Draws, Interval, Parameter, Parameters
from .results import Document, Prediction, Validation

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .study import Study


class Identification(Document):
    """An identified machine: parameters with intervals, predictions, FRFs.

    >>> found = study.identify(seed=1)
    >>> found.parameters["k_n"].unit
    'N/m'
    """

    #: Reopens the study of a document on a measurement set; set by the module of studies, which imports this one.
    _reopen: ClassVar[Function[[Mapping[str, Any], MeasurementSet], Study]]

    def __init__(self, core: _core.Identification, study: Study) -> None:
        self._core, self.study = core, study
        self._text: str | None = None

    @property
    def json(self) -> str:
        """The document as JSON text."""
        if self._text is None:
            self._text = self._core.json()
        return self._text

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        *,
        measurements: MeasurementSet | str | os.PathLike[str] | None = None,
    ) -> Identification:
        """Reads an `identification.json`, with its machine, measurement set and split.

        The set is `measurements`, else the one that :meth:`save` wrote beside the file, else the folder that the file names.

        >>> found.save("bench.json", replace=True)
        >>> jd.Identification.load("bench.json").cost == found.cost
        True

        Raises
        ------
        InputError
            The file is no identification, or its measurement set cannot be read.
        """
        file = _arrays.path("path", path)
        try:
            text = Path(file).read_text(encoding="utf-8")
        except OSError as fault:
            raise InputError(
                f"{file}: cannot be read ({fault.strerror or fault})", file=file, key="path"
            ) from None
        try:
            document = json.loads(text)
            named = document["settings"]["measurements"]
            read = _set_of_document(file, named, measurements)
            study = cls._reopen(document, read)
        except (ValueError, KeyError, TypeError) as fault:
            if isinstance(fault, InputError):
                raise
            raise InputError(
                f"{file}: is no identification.json ({fault}); name the file that identify has written",
                file=file,
            ) from None
        return cls(study._core.identification(text), study)

    def save(self, path: str | os.PathLike[str], *, replace: bool = False) -> None:
        """Writes the document as a JSON file, which the command reads.

        A measurement set that is no folder (arrays, universal files, tables) is written beside it, into a folder of the same name that ends with `.set`.

        >>> found.save("bench.json", replace=True)

        Raises
        ------
        InputError
            A file is there that jointid has not written, and `replace` is not given; nothing is written then.
        """
        measurements = self.study.measurements
        target = Path(_arrays.path("path", path))
        files = {target.name: self.json.encode()}
        if measurements.in_memory:
            files |= {f"{_beside(target).name}/{name}": text for name, text in measurements._files().items()}
        _core.write_files(target.parent, list(files.items()), False, replace)

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

        Examples
        --------
        >>> of_taps.frf([20.0, 50.0, 100.0], nut_m=[0.7, 1.2]).shape
        (2, 3)
        """
        return frf_of(
            self._core,
            self.study.quantity,
            frequency_hz,
            nut_m,
            positions,
            response,
            excitation,
            quantity,
            closed_loop,
        )

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

        >>> found.predict(nut_m=[0.5, 0.9]).to_frame()["order"].tolist()[:2]
        [1, 2]
        """
        nuts, names = places(nut_m, positions)
        lines = None if frequency_hz is None else _arrays.frequencies("frequency_hz", frequency_hz).tolist()
        with progress_of(progress, "predict") as callback:
            drawn = _arrays.optional_count("draws", draws, 1)
            band = _arrays.band("band_hz", band_hz)
            text = self._core.predict(
                nuts,
                names,
                bool(frf) or lines is not None,
                lines,
                band,
                drawn,
                _arrays.count("seed", seed),
                running_of(callback, threads),
            )
        return Prediction(text)

    def draws(
        self,
        count: int,
        *,
        seed: int = 1,
        bootstrap: bool | None = None,
        threads: int | None = None,
        progress: bool | Callback | None = False,
    ) -> Draws:
        """Draws machines that the data leave possible: by a bootstrap over lines (the default for FRFs), or from the posterior.

        About each minimum that the data do not distinguish `count` machines are drawn.

        >>> found.draws(5, bootstrap=False).weight.tolist()[:5]
        [1.0, 1.0, 1.0, 1.0, 1.0]
        """
        lines = self.document["settings"]["objective"] == "frf" if bootstrap is None else bool(bootstrap)
        with progress_of(progress, "draw") as callback:
            ids, values, minima = self._core.draws(
                _arrays.count("count", count, 1),
                _arrays.count("seed", seed),
                lines,
                running_of(callback, threads),
            )
        costs = np.array([basin["cost"] for basin in self.document.get("basins", ())] or [0.0])
        return Draws(ids, values, np.array(minima), np.exp(0.5 * (costs[0] - costs))[minima])

    def validate(
        self,
        positions: str | Sequence[str] | None = None,
        *,
        measurements: MeasurementSet | str | os.PathLike[str] | None = None,
    ) -> Validation:
        """Predicts what was held out, the named positions, or another measurement set, and returns the errors.

        >>> sorted(found.validate().overall_error)
        ['l2', 'l4', 'l6']
        """
        names = None if positions is None else _arrays.names("positions", positions)
        other = None if measurements is None else MeasurementSet.of(measurements)
        return Validation(self._core.validate(names, None if other is None else other._core))

    def machine(self) -> Machine:
        """The machine as identified: parameters start at their estimates, tolerances are held at theirs.

        >>> print(found.machine().static_stiffness("table", nut_m=0.9) > 1e6)
        True
        """
        return Machine.from_text(self._core.machine(), self.study.machine.path)

    def profile(
        self, parameter: str, points: int | ArrayLike = 9, *, threads: int | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Profile of the objective over a parameter: it is held at each value, and all others are fitted anew.

        `points` is a number of values over 1.5 times the 95 % interval, or the values. Returns values (n,), in the parameter's unit, and costs (n,).

        >>> values, costs = of_taps.profile("k_n", [of_taps.parameters["k_n"].value])
        >>> print(abs(costs[0] - of_taps.cost) < 0.1)
        True
        """
        _arrays.unknown("parameter", [_arrays.name("parameter", parameter)], self.parameters)
        row = self.parameters[parameter]
        if not row.fitted:
            raise argument("parameter", f"«{parameter}» was not fitted; name one that was")
        if isinstance(points, (int, np.integer)) or np.ndim(points) == 0:
            low, high = row.interval95 or (row.lower, row.upper)
            low, high = (
                max(row.lower, row.value - 1.5 * (row.value - low)),
                min(row.upper, row.value + 1.5 * (high - row.value)),
            )
            ratio = high / low if low > 0 else np.inf
            count = _arrays.count("points", points, 2)
            values = np.geomspace(low, high, count) if 10 < ratio < np.inf else np.linspace(low, high, count)
        else:
            values = _arrays.real_array("points", points)
        costs = [
            self.study.overridden({f"parameter.{parameter}.start": value})._cost_with_frozen(
                parameter, threads
            )
            for value in values
        ]
        return values, np.array(costs)

    def to_frame(self) -> pandas.DataFrame:
        """The parameters as a table, as :meth:`Parameters.to_frame`.

        >>> found.to_frame().loc["k_n", "unit"]
        'N/m'
        """
        return self.parameters.to_frame()

    def plot(self, positions: str | Sequence[str] | None = None, *, ax: Axes | Any = None) -> Figure:
        """Draws the measurements with the machine before and after: FRFs, else natural frequencies.

        `ax` is one axes of Matplotlib, or as many as the figure has panels: magnitude and phase for each FRF, one for each order of natural frequencies.

        >>> figure = of_taps.plot(["p1", "p2"])
        >>> len(figure.axes)
        4
        """
        from . import plot

        return plot.identification(
            self, None if positions is None else _arrays.names("positions", positions), ax
        )

    def plot_profile(self, parameter: str, points: int | ArrayLike = 9, *, ax: Axes | None = None) -> Figure:
        """Draws the profile of the objective over a parameter (see :meth:`profile`), with the 95 % interval.

        >>> figure = of_taps.plot_profile("k_n", 2)
        """
        from . import plot

        return plot.profile(self, parameter, points, ax)

    def plot_modes(
        self,
        *,
        nut_m: float | None = None,
        position: str | None = None,
        max_hz: float = 1000.0,
        ax: Axes | Any = None,
    ) -> Figure:
        """Draws mode shapes of the identified machine: displacements (m) and angles (rad) apart, each relative to its largest.

        >>> figure = found.plot_modes(nut_m=0.9, max_hz=300.0)
        """
        from . import plot

        return plot.modes(self, nut_m, position, max_hz, ax)

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.study, self.json)

    def _quality(self) -> dict[str, str]:
        """Gap and χ² as text, by their names."""
        derived = self.derived
        named = {
            "gap_fit": "gap at fitted data",
            "gap_held_out": "gap at held-out data",
            "largest_frequency_error_fit": "largest frequency error at fitted positions",
            "largest_frequency_error_held_out": "largest frequency error at held-out positions",
        }
        rows = {words: f"{100 * derived[key]:.2f} %" for key, words in named.items() if key in derived}
        if freedom := derived.get("degrees_of_freedom"):
            rows["χ² per degree of freedom"] = f"{self.cost / freedom:.2f} ({self.cost:.4g} / {freedom:.0f})"
        return rows

    def _repr_html_(self) -> str:
        head = f"{self.study.machine.title}, fitted: {', '.join(self.document['fit_positions'])}"
        return _html.page(
            "Identification", head, [_html.pairs(self._quality()), self.parameters._repr_html_()], self.warnings
        )

    def __repr__(self) -> str:
        lines = [
            f"<Identification of «{self.study.machine.title}», fitted: {', '.join(self.document['fit_positions'])}"
        ]
        for name, row in self.parameters.items():
            lines.append(f"  {name} = {row.value:.4g} {row.unit}  {row._ends()}  {row._status()}")
        lines += [f"  {words}: {text}" for words, text in self._quality().items()]
        lines += [f"  warning: {warning}" for warning in self.warnings]
        return "\n".join(lines) + ">"


def _restored(study: Study, text: str) -> Identification:
    return Identification(study._core.identification(text), study)


def _beside(file: Path) -> Path:
    """Folder of the measurement set that is saved with a document."""
    return file.with_suffix(".set")


def _set_of_document(file: str, named: str, given: Any) -> MeasurementSet:
    """The measurement set of a document: the given one, the one beside it, or the folder that it names."""
    if given is not None:
        return MeasurementSet.of(given)
    beside = _beside(Path(file))
    try:
        if (beside / "manifest.toml").is_file():
            contents: Mapping[str, bytes] = dict(MeasurementSet(beside)._core.files())
            return MeasurementSet.from_files(contents, named)
        return MeasurementSet(named)
    except InputError as fault:
        raise InputError(
            f"{file}: its measurement set «{named}» cannot be read ({fault}); give it as load(…, measurements=…)",
            file=file,
            key="measurements",
        ) from None
