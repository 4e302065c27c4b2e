"""Studies and identifications: a machine, its measurements, what is fitted, and how; and the machine that results."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _core
from ._errors import InputError, argument
from ._frf import frf_of, places
from ._progress import Callback, progress_of
from ._settings import CHECKS, Settings, checked
from .machine import Machine
from .measurement import MeasurementSet
from .results import (
    Comparison,
    Diagnosis,
    Draws,
    Document,
    Friction,
    Interval,
    Parameter,
    Parameters,
    Peaks,
    Plan,
    Prediction,
    Validation,
)

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure
    from typing_extensions import Unpack

Path = str | os.PathLike[str]
# Machine of the published bench, which is built in.
BENCH = "configs/tian.toml"


class _State(NamedTuple):
    """What a study was made of, beside its machine."""

    measurements: MeasurementSet
    overrides: list[str]
    without: list[str]
    fit: list[str] | None
    hold_out: list[str]
    settings: dict[str, Any]


class Study:
    """A machine with its measurements, what is fitted, and how. Every method returns a new study or a result; pickles with machine and measurements.

    Parameters
    ----------
    machine : path or Machine
        Description of the machine; that of the published bench where absent.
    measurements : path or MeasurementSet
        Folder of the measurement set, or the set; where absent, the built-in one that the description names.
    overrides : mapping of key path to value
        Numbers of the description to replace, such as ``{"parameter.k_n.start": 4e8}``.
    without : list of str
        Effects to take out of the description.

    Raises
    ------
    InputError
        A file cannot be read or does not describe a machine or a set; `file`, `line` and `key` say where.
    """

    def __init__(
        self,
        machine: Path | Machine | None = None,
        measurements: Path | MeasurementSet | None = None,
        *,
        overrides: Mapping[str, Any] | None = None,
        without: str | Sequence[str] = (),
    ) -> None:
        over, out = _overrides(overrides or {}), _arrays.names("without", without)
        in_memory = isinstance(machine, Machine) or isinstance(measurements, MeasurementSet)
        if not in_memory:
            config = None if machine is None else _arrays.path("machine", machine)
            folder = None if measurements is None else _arrays.path("measurements", measurements)
            core = _core.Study.open(config, folder, over, out)
            read = MeasurementSet._of(core.measurements)
        else:
            described = machine if isinstance(machine, Machine) else Machine(machine or BENCH)
            read = _set_of(described, measurements)
            core = _core.Study(described.path, described.text, read._core, over, out)
        self._core = core
        self._state = _State(read, over, out, None, [], {})

    @classmethod
    def _made(cls, core: _core.Study, state: _State) -> Study:
        made = cls.__new__(cls)
        made._core, made._state = core, state
        return made

    def _with(self, core: _core.Study, **changed: Any) -> Study:
        return Study._made(core, self._state._replace(**changed))

    @property
    def machine(self) -> Machine:
        """The machine as described; overrides and removed effects are not applied to its text."""
        path, text, _ = self._core.machine
        return Machine.from_text(text, path)

    @property
    def measurements(self) -> MeasurementSet:
        """The measurement set."""
        return self._state.measurements

    @property
    def parameters(self) -> list[str]:
        """Ids of the machine's parameters."""
        return self._core.parameters

    @property
    def quantity(self) -> str:
        """Quantity of the measured FRFs or amplitudes."""
        return self._core.quantity

    def fit(self, names: str | Sequence[str]) -> Study:
        """Chooses the positions or records to fit; all others are held out."""
        listed = _arrays.names("names", names)
        return self._with(self._core.fit(listed), fit=listed)

    def hold_out(self, names: str | Sequence[str]) -> Study:
        """Chooses positions or records to hold out, in addition to those that are not fitted."""
        listed = _arrays.names("names", names)
        return self._with(self._core.hold_out(listed), hold_out=listed)

    def without(self, effects: str | Sequence[str]) -> Study:
        """Takes effects out of the machine's description, as if it had never contained them."""
        listed = _arrays.names("effects", effects)
        return self._with(self._core.without(listed), without=[*self._state.without, *listed])

    def with_settings(self, **settings: Unpack[Settings]) -> Study:
        """Keeps settings for identification and diagnosis, see :class:`Settings`."""
        return self._with(self._core, settings=self._state.settings | checked(settings))

    def with_machine(self, machine: Machine | Path) -> Study:
        """Replaces the machine; measurements, split and settings stay."""
        described = machine if isinstance(machine, Machine) else Machine(machine)
        core = _core.Study(described.path, described.text, self._state.measurements._core, [], [])
        return self._with(_split(core, self._state.fit, self._state.hold_out), overrides=[], without=[])

    def overridden(self, overrides: Mapping[str, Any]) -> Study:
        """Replaces numbers of the machine's description, such as ``{"parameter.k_n.start": 4e8}``."""
        over = [*self._state.overrides, *_overrides(overrides)]
        path, text, _ = self._core.machine
        core = _core.Study(path, text, self._state.measurements._core, over, self._state.without)
        return self._with(_split(core, self._state.fit, self._state.hold_out), overrides=over)

    def identify(
        self,
        *,
        seed: int = 1,
        threads: int | None = None,
        progress: bool | Callback | None = None,
        **settings: Unpack[Settings],
    ) -> Identification:
        """Identifies the machine's free parameters from the fitted data, and predicts the held-out data.

        Parameters
        ----------
        seed : int
            Seed of the random numbers: the same seed gives the same bits, on any number of threads.
        threads : int
            Number of threads; all cores by default.
        progress : bool or function of (stage, done, of)
            A bar in terminals and notebooks by default; `done` and `of` are None where the end is not known.
        **settings
            See :class:`Settings`.

        Raises
        ------
        InputError
            A setting is outside its range, machine and set do not fit together, the data do not suffice.
        KeyboardInterrupt
            Within half a second of Ctrl-C.
        """
        study = self._set(seed, settings)
        with progress_of(progress, "identify") as callback:
            core = study._core.identify(_running(callback, threads))
        return Identification(core, study)

    def diagnose(
        self,
        *,
        effects: str | Sequence[str] = (),
        exclude: str | Sequence[str] = (),
        nulls: int | None = None,
        cache: Path | None = None,
        ablate: str | Sequence[str] = (),
        seed: int = 1,
        threads: int | None = None,
        progress: bool | Callback | None = None,
        **settings: Unpack[Settings],
    ) -> Diagnosis:
        """Diagnoses the discrepancy between machine and data: where, which effect, and how far it closes the gap.

        Parameters
        ----------
        effects, exclude : list of str
            Candidates (all that apply by default), and those to leave out.
        nulls : int
            Null simulations whose fits are made in full, beside 2000 linear ones (40; 25 times as many for motion records).
        cache : path
            Folder in which null simulations are kept; none by default.
        ablate : list of {"chi-square", "frozen-nominal", "no-nuisances", "in-sample"}
            Parts of the method to switch off, to see what they do.
        seed, threads, progress, **settings
            As for :meth:`identify`.
        """
        study = self._set(seed, settings)
        given = {
            "effects": _arrays.names("effects", effects),
            "exclude": _arrays.names("exclude", exclude),
            "nulls": _arrays.optional_count("nulls", nulls, 1),
            "cache": None if cache is None else _arrays.path("cache", cache),
            "ablate": _arrays.names("ablate", ablate),
        }
        with progress_of(progress, "diagnose") as callback:
            text = study._core.diagnose(given, _running(callback, threads))
        return Diagnosis(text, study)

    def compare(
        self,
        single: str | Sequence[str] | None = None,
        *,
        seed: int = 1,
        threads: int | None = None,
        progress: bool | Callback | None = None,
        **settings: Unpack[Settings],
    ) -> Comparison:
        """Compares the identification from all fitted positions with one from each of the `single` positions alone."""
        names = None if single is None else _arrays.names("single", single)
        with progress_of(progress, "compare") as callback:
            return Comparison(self._set(seed, settings)._core.compare(names, _running(callback, threads)))

    def plan(
        self,
        *,
        found: Identification | None = None,
        diagnosis: Diagnosis | None = None,
        data: str | None = None,
        choose: int | Sequence[int] = (),
        measured: str | Sequence[str] = (),
        channels: str | Sequence[str] = (),
        states: str | Sequence[str] = (),
        predict_at_m: Sequence[float] = (),
        noise: float | None = None,
        band_hz: Interval | None = None,
        lines: int | None = None,
        threads: int | None = None,
        progress: bool | Callback | None = None,
    ) -> Plan:
        """Ranks choices of positions, channels and operating states by what they decide.

        Parameters
        ----------
        found : Identification
            Its values count instead of the start values.
        diagnosis : Diagnosis
            An ambiguous one: the probability that a choice settles it decides.
        data : {"modes", "frf"}
        choose : int or list of int
            Numbers of measurements to choose.
        measured : list of str
            Measurements already made: positions, or ``position:response/excitation``.
        channels, states : list of str
            To choose from: ``response/excitation``; ``as-is``, ``servo-off``, ``mass=KG``, ``level=N``.
        predict_at_m : list of float
            Nut positions (m) whose predicted natural frequencies decide.
        noise, band_hz, lines
            Relative standard deviation of an FRF line (0.02), band (Hz) and number of lines (400).
        """
        chosen = [choose] if isinstance(choose, (int, np.integer)) else choose
        given = {
            "data": _arrays.optional_name("data", data),
            "choose": [_arrays.count("choose", count, 1) for count in chosen],
            "measured": _arrays.names("measured", measured),
            "channels": _arrays.names("channels", channels),
            "states": _arrays.names("states", states),
            "predict_at_m": [_arrays.number("predict_at_m", at) for at in predict_at_m],
            "diagnosis": None if diagnosis is None else diagnosis.json,
            "noise": None if noise is None else _arrays.number("noise", noise),
            "band_hz": _arrays.band("band_hz", band_hz),
            "lines": _arrays.optional_count("lines", lines, 2),
        }
        study = self._set(1, {})
        with progress_of(progress, "plan") as callback:
            return Plan(
                study._core.plan(None if found is None else found._core, given, _running(callback, threads))
            )

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
        """Computes FRFs at the start values of the parameters; else as :meth:`Identification.frf`."""
        return frf_of(
            self._core,
            self.quantity,
            frequency_hz,
            nut_m,
            positions,
            response,
            excitation,
            quantity,
            closed_loop,
        )

    def modes(
        self, *, nut_m: float | None = None, position: str | None = None, max_hz: float = 1000.0
    ) -> Document:
        """Undamped natural frequencies and mode shapes at the start values, up to `max_hz`; mid-stroke by default."""
        at = None if nut_m is None else _arrays.number("nut_m", nut_m, "give a distance in m")
        return Document(
            self._core.modes(
                at, _arrays.optional_name("position", position), _arrays.number("max_hz", max_hz)
            )
        )

    def _set(self, seed: int, settings: Mapping[str, Any]) -> Study:
        kept = self._state.settings | checked(settings)
        given = dict.fromkeys(CHECKS) | kept | {"seed": _arrays.count("seed", seed)}
        return self._with(self._core.with_settings(given), settings=kept)

    def _cost_with_frozen(self, parameter: str, threads: int | None) -> float:
        frozen = [*self._state.settings.get("freeze", ()), parameter]
        return self.identify(freeze=frozen, threads=threads, progress=False).cost

    def __reduce__(self):
        path, text, _ = self._core.machine
        return _restored, (path, text, self._state)

    def __repr__(self) -> str:
        fitted = f", fitted: {', '.join(self._state.fit)}" if self._state.fit is not None else ""
        return f"<Study of «{self._core.machine[2]}» with {self._state.measurements.path}{fitted}>"


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
        file = _arrays.path("path", path)
        try:
            with open(file, encoding="utf-8") as opened:
                text = opened.read()
            study = _study_of_document(json.loads(text))
        except OSError as fault:
            raise InputError(
                f"{file}: cannot be read ({fault.strerror or fault})", file=file, key="path"
            ) from None
        except (ValueError, KeyError, TypeError) as fault:
            if isinstance(fault, InputError):
                raise
            raise InputError(
                f"{file}: is no identification.json ({fault}); name the file that identify has written",
                file=file,
            ) from None
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
        """
        nuts, names = places(nut_m, positions)
        lines = None if frequency_hz is None else _arrays.frequencies("frequency_hz", frequency_hz).tolist()
        with progress_of(progress, "predict") as callback:
            running = {"progress": callback, "threads": _arrays.optional_count("threads", threads, 1)}
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
                running,
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
        """
        lines = self.document["settings"]["objective"] == "frf" if bootstrap is None else bool(bootstrap)
        with progress_of(progress, "draw") as callback:
            running = {"progress": callback, "threads": _arrays.optional_count("threads", threads, 1)}
            ids, values, minima = self._core.draws(
                _arrays.count("count", count, 1), _arrays.count("seed", seed), lines, running
            )
        costs = np.array([basin["cost"] for basin in self.document.get("basins", ())] or [0.0])
        return Draws(ids, values, np.array(minima), np.exp(0.5 * (costs[0] - costs))[minima])

    def validate(
        self,
        positions: str | Sequence[str] | None = None,
        *,
        measurements: MeasurementSet | str | os.PathLike[str] | None = None,
    ) -> Validation:
        """Predicts what was held out, the named positions, or another measurement set, and returns the errors."""
        names = None if positions is None else _arrays.names("positions", positions)
        other = (
            measurements
            if measurements is None or isinstance(measurements, MeasurementSet)
            else MeasurementSet(measurements)
        )
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

    def plot_modes(
        self, *, nut_m: float | None = None, position: str | None = None, max_hz: float = 1000.0
    ) -> Figure:
        """Mode shapes of the identified machine: displacement of every point."""
        from . import plot

        return plot.modes(self, nut_m, position, max_hz)

    def __reduce__(self):
        return _restored_identification, (self.study, self.json)

    def __repr__(self) -> str:
        lines = [
            f"<Identification of «{self.study.machine.title}», fitted: {', '.join(self.document['fit_positions'])}"
        ]
        for name, row in self.parameters.items():
            interval = f"  {row.interval95[0]:.4g} … {row.interval95[1]:.4g}" if row.interval95 else ""
            depends = f"depends on {'; '.join(row.depends_on) or 'what the model lacks'}"
            known = {True: "identifiable", False: "not identifiable", None: depends}[row.identifiable]
            lines.append(
                f"  {name} = {row.value:.4g} {row.unit}{interval}{'  ' + known if row.fitted else '  held'}"
            )
        return "\n".join(lines) + ">"


def _restored_identification(study: Study, text: str) -> Identification:
    return Identification(study._core.identification(text), study)


def _restored(path: str, text: str, state: _State) -> Study:
    core = _core.Study(path, text, state.measurements._core, state.overrides, state.without)
    return Study._made(_split(core, state.fit, state.hold_out), state)


def _study_of_document(document: Mapping[str, Any]) -> Study:
    """Reopens the study of an identification."""
    made, settings = document.get("machine"), document["settings"]
    machine = Machine.from_text(made["text"], made["path"]) if made else Machine(settings["config"])
    fit_tolerances = settings["tolerances"] == "fit" or settings["objective"] != "frf"
    kept = {key: settings[key] for key in CHECKS if settings.get(key) is not None} | {
        "tolerances": fit_tolerances
    }
    over, out = document.get("overrides", []), document.get("without", [])
    state = _State(
        MeasurementSet(settings["measurements"]),
        over,
        out,
        settings.get("positions"),
        settings.get("hold_out", []),
        {},
    )
    return _restored(machine.path, machine.text, state).with_settings(**kept)._set(document["seed"], {})


def _split(core: _core.Study, fit: list[str] | None, hold_out: list[str]) -> _core.Study:
    if fit is not None:
        core = core.fit(fit)
    return core.hold_out(hold_out) if hold_out else core


def _set_of(machine: Machine, measurements: Path | MeasurementSet | None) -> MeasurementSet:
    if isinstance(measurements, MeasurementSet):
        return measurements
    folder = machine._core.measurements if measurements is None else measurements
    if folder is None:
        raise argument(
            "measurements", f"is missing, and {machine.path} names no set; give a folder or a MeasurementSet"
        )
    return MeasurementSet(folder)


def _overrides(given: Mapping[str, Any]) -> list[str]:
    def text(value: Any) -> str:
        if isinstance(value, (bool, np.bool_)):
            return "true" if value else "false"
        return repr(float(value)) if isinstance(value, np.floating) else str(value)

    return [f"{key}={text(value)}" for key, value in _arrays.mapping("overrides", given).items()]


def _running(callback: Callback | None, threads: int | None) -> dict[str, Any]:
    return {"progress": callback, "threads": _arrays.optional_count("threads", threads, 1)}


def peaks(
    measurements: MeasurementSet | Path,
    *,
    band_hz: Interval | None = None,
    local: bool = False,
    max_order: int | None = None,
) -> Peaks:
    """Extracts natural frequencies, damping ratios and amplitudes from the FRFs of a set, and tracks them over its positions.

    `band_hz` restricts the lines; with `local` only the modes in it are fitted, and the others enter as background. `max_order` is the highest polynomial
    order of the stabilisation diagram (48).
    """
    read = measurements if isinstance(measurements, MeasurementSet) else MeasurementSet(measurements)
    text, table = _core.peaks(
        read._core,
        _arrays.band("band_hz", band_hz),
        bool(local),
        _arrays.optional_count("max_order", max_order, 8),
    )
    return Peaks(text, table, read)


def plan(
    machine: Path | Machine | None = None, measurements: Path | MeasurementSet | None = None, **request: Any
) -> Plan:
    """Ranks choices of measurements, see :meth:`Study.plan`."""
    return Study(machine, measurements).plan(**request)


def friction(
    path: Path, *, lead_m: float | None = None, efficiency: float = 1.0, noise: str | None = None
) -> Friction:
    """Fits a Stribeck curve to a table with the columns `velocity_m_s` and `force_n` (or `torque_nm`: then give the lead in m per revolution)."""
    lead = None if lead_m is None else _arrays.number("lead_m", lead_m)
    text = _core.friction(
        _arrays.path("path", path),
        lead,
        _arrays.number("efficiency", efficiency),
        _arrays.optional_name("noise", noise),
    )
    return Friction(text)


def effects(id: str | None = None, *, machine: Path | None = None) -> Document:
    """Lists the library of effects, with those of a machine's description where one is named; or the one with an id."""
    return Document(
        _core.effects(
            None if machine is None else _arrays.path("machine", machine), _arrays.optional_name("id", id)
        )
    )
