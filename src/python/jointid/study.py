"""Studies: a machine, its measurements, what is fitted, and how."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _core, _html
from ._errors import argument
from ._frf import frf_of
from ._progress import Callback, progress_of, running_of
from ._settings import CHECKS, Settings, checked
from .diagnosis import Diagnosis
from .identification import Identification
from .machine import Machine
from .measurement import MeasurementSet
from .parameters import Interval
from .results import Comparison, Plan
from .simulation import Modes, Motion, MotionSettings, modes_of, motion_of, stiffness_of

if TYPE_CHECKING:
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

    Examples
    --------
    >>> jd.Study().parameters[:2]                      # the published bench
    ['c_al', 'c_ar']
    >>> study = jd.Study("configs/tian.toml", taps)    # a file of the machine, and arrays
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
            read = MeasurementSet._of(core.measurements, in_memory=False)
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

    def choose_fit(self, names: str | Sequence[str]) -> Study:
        """Chooses the positions or records that :meth:`identify` fits; all others are held out.

        >>> jd.Study().choose_fit(["l1", "l3", "l5"])
        <Study of «published ball-screw bench, rotor held» with measurements/tian, fitted: l1, l3, l5>
        """
        listed = _arrays.names("names", names)
        return self._with(self._core.fit(listed), fit=listed)

    def hold_out(self, names: str | Sequence[str]) -> Study:
        """Chooses positions or records to hold out, in addition to those that are not fitted.

        >>> sorted(jd.Study("configs/tian.toml", taps).hold_out("p2").identify().validate().overall_error)
        ['p2']
        """
        listed = _arrays.names("names", names)
        return self._with(self._core.hold_out(listed), hold_out=listed)

    def without(self, effects: str | Sequence[str]) -> Study:
        """Takes effects out of the machine's description, as if it had never contained them.

        >>> "k_s" in study.parameters, "k_s" in study.without("rotor-hold").parameters
        (True, False)
        """
        listed = _arrays.names("effects", effects)
        return self._with(self._core.without(listed), without=[*self._state.without, *listed])

    def with_settings(self, **settings: Unpack[Settings]) -> Study:
        """Keeps settings for identification and diagnosis, see :class:`Settings`.

        >>> study.with_settings(freeze=["k_m"]).identify().parameters["k_m"].fitted
        False
        """
        return self._with(self._core, settings=self._state.settings | checked(settings))

    def with_machine(self, machine: Machine | Path) -> Study:
        """Replaces the machine; measurements, split and settings stay.

        >>> study.with_machine("configs/tian-as-published.toml").machine.path
        'configs/tian-as-published.toml'
        """
        described = machine if isinstance(machine, Machine) else Machine(machine)
        core = _core.Study(described.path, described.text, self._state.measurements._core, [], [])
        return self._with(_split(core, self._state.fit, self._state.hold_out), overrides=[], without=[])

    def overridden(self, overrides: Mapping[str, Any]) -> Study:
        """Replaces numbers of the machine's description, by the paths of their keys.

        >>> softer = study.overridden({"parameter.k_n.start": 4e8})
        """
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

        Examples
        --------
        >>> study.identify(seed=2, freeze=["k_m"], tolerances=False).parameters["k_n"].fitted
        True
        """
        study = self._set(seed, settings)
        with progress_of(progress, "identify") as callback:
            core = study._core.identify(running_of(callback, threads))
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

        Examples
        --------
        >>> diagnosis = study.without("rotor-hold").diagnose(effects=["rotor-hold", "guide-stiffness"])
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
            text = study._core.diagnose(given, running_of(callback, threads))
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
        """Compares the identification from all fitted positions with one from each of the `single` positions alone.

        >>> sorted(study.compare(["l3"]).common_error)
        ['l3', 'multi']
        """
        names = None if single is None else _arrays.names("single", single)
        with progress_of(progress, "compare") as callback:
            return Comparison(self._set(seed, settings)._core.compare(names, running_of(callback, threads)))

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

        Examples
        --------
        >>> len(study.plan(choose=2).best)
        2
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
                study._core.plan(None if found is None else found._core, given, running_of(callback, threads))
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
        """Computes FRFs at the start values of the parameters; else as :meth:`Identification.frf`.

        >>> study.frf([20.0, 50.0], positions="l1", response="table", excitation="table").shape
        (2,)
        """
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
    ) -> Modes:
        """Computes undamped natural frequencies and mode shapes at the start values, up to `max_hz`; mid-stroke by default.

        >>> study.modes(position="l1").shapes.ndim
        2
        """
        return modes_of(self._core, nut_m, position, max_hz)

    def static_stiffness(
        self,
        point: str,
        *,
        nut_m: float | Sequence[float] | None = None,
        positions: str | Sequence[str] | None = None,
    ) -> NDArray[np.float64]:
        """Computes the static stiffness (N/m or N·m/rad) of a point at the start values; mid-stroke by default.

        >>> study.static_stiffness("table", positions=["l1", "l6"]).shape
        (2,)
        """
        return stiffness_of(self._core, point, nut_m, positions)

    def simulate_motion(
        self,
        record: str | None = None,
        *,
        position: str | None = None,
        threads: int | None = None,
        progress: bool | Callback | None = None,
        **motion: Unpack[MotionSettings],
    ) -> Motion:
        """Simulates the driven axis at the start values: along the command of a `record` of the set, else as :meth:`Machine.simulate_motion`, from the
        named `position`.

        >>> jd.Study(drive, taps).simulate_motion(sine=(0.01, 2.0, 3.0)).complete
        True
        """
        return motion_of(self._core, motion, (record, position), threads, progress)

    def _set(self, seed: int, settings: Mapping[str, Any]) -> Study:
        kept = self._state.settings | checked(settings)
        given = dict.fromkeys(CHECKS) | kept | {"seed": _arrays.count("seed", seed)}
        return self._with(self._core.with_settings(given), settings=kept)

    def _cost_with_frozen(self, parameter: str, threads: int | None) -> float:
        frozen = [*self._state.settings.get("freeze", ()), parameter]
        return self.identify(freeze=frozen, threads=threads, progress=False).cost

    def _repr_html_(self) -> str:
        fitted = "as the set states" if self._state.fit is None else ", ".join(self._state.fit)
        named = {"fitted": fitted, "effects taken out": ", ".join(self._state.without) or "none"}
        parts = [_html.pairs(named), self.measurements._repr_html_()]
        return _html.page("Study", f"«{self._core.machine[2]}»", parts, self.machine.warnings)

    def __reduce__(self) -> tuple[Any, ...]:
        path, text, _ = self._core.machine
        return restored, (path, text, self._state)

    def __repr__(self) -> str:
        fitted = f", fitted: {', '.join(self._state.fit)}" if self._state.fit is not None else ""
        return f"<Study of «{self._core.machine[2]}» with {self._state.measurements.path}{fitted}>"


def restored(path: str, text: str, state: _State) -> Study:
    core = _core.Study(path, text, state.measurements._core, state.overrides, state.without)
    return Study._made(_split(core, state.fit, state.hold_out), state)


def study_of_document(document: Mapping[str, Any], measurements: MeasurementSet) -> Study:
    """Reopens the study of an identification, on a measurement set."""
    made, settings = document.get("machine"), document["settings"]
    machine = Machine.from_text(made["text"], made["path"]) if made else Machine(settings["config"])
    fit_tolerances = settings["tolerances"] == "fit" or settings["objective"] != "frf"
    kept = {key: settings[key] for key in CHECKS if settings.get(key) is not None}
    kept |= {"tolerances": fit_tolerances}
    over, out = document.get("overrides", []), document.get("without", [])
    split = (settings.get("positions"), settings.get("hold_out", []))
    state = _State(measurements, over, out, *split, {})
    return restored(machine.path, machine.text, state).with_settings(**kept)._set(document["seed"], {})


Identification._reopen = staticmethod(study_of_document)


def _split(core: _core.Study, fit: list[str] | None, hold_out: list[str]) -> _core.Study:
    if fit is not None:
        core = core.fit(fit)
    return core.hold_out(hold_out) if hold_out else core


def _set_of(machine: Machine, measurements: Path | MeasurementSet | None) -> MeasurementSet:
    given = machine._core.measurements if measurements is None else measurements
    if given is None:
        raise argument(
            "measurements", f"is missing, and {machine.path} names no set; give a folder or a MeasurementSet"
        )
    return MeasurementSet.of(given)


def _overrides(given: Mapping[str, Any]) -> list[str]:
    def text(value: Any) -> str:
        if isinstance(value, (bool, np.bool_)):
            return "true" if value else "false"
        return repr(float(value)) if isinstance(value, np.floating) else str(value)

    return [f"{key}={text(value)}" for key, value in _arrays.mapping("overrides", given).items()]
