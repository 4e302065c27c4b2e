"""Measurement sets: from folders, arrays, universal files and tables."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _core
from ._errors import InputError, argument

Paths = "str | os.PathLike[str] | Sequence[str | os.PathLike[str]]"


@dataclass(frozen=True)
class Frf:
    """A measured FRF, H = response / force with e^{+iωt}; lines whose coherence is too low are left out.

    `frequency_hz` has the shape (lines,), in Hz; `value` (lines,), complex, in m/N, (m/s)/N or (m/s²)/N by `quantity`; `coherence` and `relative_sd`
    (standard deviation of the complex mean over |H|) are (lines,) where stated.
    """

    position: str | None
    record: str | None
    response: str
    excitation: str
    quantity: str
    averages: int | None
    frequency_hz: NDArray[np.float64]
    value: NDArray[np.complex128]
    coherence: NDArray[np.float64] | None
    relative_sd: NDArray[np.float64] | None


class MeasurementSet:
    """Observations of one machine: FRFs, natural frequencies, or motion records. Pickles with its contents.

    Parameters
    ----------
    folder : path
        Folder with a `manifest.toml`; `measurements/tian` is built in.
    allow_outside : bool
        Whether the files that the manifest names may lie outside the folder.

    Raises
    ------
    InputError
        A file is missing, a key is unknown, a cell is no number; `file`, `line` and `key` say where.
    """

    def __init__(self, folder: str | os.PathLike[str], *, allow_outside: bool = False) -> None:
        self._core = _core.MeasurementSet.read(_arrays.path("folder", folder), allow_outside)
        self._arrays: tuple[Any, ...] | None = None

    @classmethod
    def _of(cls, core: _core.MeasurementSet, arrays: tuple[Any, ...] | None = None) -> MeasurementSet:
        made = cls.__new__(cls)
        made._core, made._arrays = core, arrays
        return made

    @classmethod
    def from_files(cls, files: Mapping[str, bytes | str], name: str = "measurements") -> MeasurementSet:
        """Reads a set from the contents of its files by name, `manifest.toml` among them; `name` stands for its folder in messages and documents."""
        contents = {
            file: content.encode() if isinstance(content, str) else bytes(content)
            for file, content in _arrays.mapping("files", files).items()
        }
        return cls._of(_core.MeasurementSet.from_files(_arrays.name("name", name), contents))

    @classmethod
    def from_arrays(
        cls,
        frequency_hz: ArrayLike | Mapping[str, ArrayLike] | None = None,
        frfs: Mapping[str, ArrayLike] | Iterable[Mapping[str, Any]] = (),
        *,
        coherence: Mapping[str, ArrayLike] | None = None,
        relative_sd: Mapping[str, ArrayLike] | None = None,
        averages: int | None = None,
        nut_m: Mapping[str, float | None] | None = None,
        quantity: str | None = None,
        response: str | None = None,
        excitation: str | None = None,
        gain: float | str = 1.0,
        gain_sd: float | None = None,
        delay_sd_s: float | None = None,
        nut_sd_m: float | None = None,
        fit: Sequence[str] | None = None,
        motions: Mapping[str, Mapping[str, ArrayLike]] | None = None,
        title: str = "arrays",
    ) -> MeasurementSet:
        """Makes a set of arrays, without files. They are copied: the set stays as it is if they change.

        Parameters
        ----------
        frequency_hz : (lines,) array, or one by position
            Frequencies in Hz, rising.
        frfs : mapping of position to (lines,) complex array, or iterable of mappings
            FRFs: response over force with e^{+iωt}. A mapping has one FRF a position. For several channels or repeats give mappings with the keys
            `frequency_hz` and `value`, and as needed `position`, `record`, `response`, `excitation`, `quantity`, `averages`, `coherence`,
            `relative_sd`, `force_n`, `speed_m_s`, `acceleration_m_s2`.
        coherence, relative_sd : mapping of position to (lines,) array
            Coherence γ² (needs `averages`), or standard deviation of the complex mean over |H|; neither: the noise is estimated from neighbouring
            lines.
        averages : int
            Number of averages of each FRF.
        nut_m : mapping of position to float
            Nut positions from the left end of the screw (m).
        quantity : {"receptance", "mobility", "accelerance"}
            Displacement, velocity or acceleration over force.
        response, excitation : str
            Points of the machine where it was measured and excited.
        gain : float or "unknown"
            Factor from prediction to record.
        gain_sd, delay_sd_s, nut_sd_m : float
            Standard deviations of ln(gain) and delay (s) of a channel and of a nut position (m).
        fit : list of str
            Positions or records to fit, where a study names no others.
        motions : mapping of record to mapping
            Motion records: `time_s`, `command_m`, `position_m`, one of `force_n` and `torque_nm`; other keys are kept by name.

        Raises
        ------
        InputError
            Arrays differ in length, are not finite or of the wrong type, frequencies do not rise, a name is no text; `key` names the argument.
        """
        given = {
            "title": _arrays.name("title", title),
            "quantity": _arrays.optional_name("quantity", quantity),
            "response": _arrays.optional_name("response", response),
            "excitation": _arrays.optional_name("excitation", excitation),
            "averages": _arrays.optional_count("averages", averages, 1),
            "gain": _gain(gain),
            "tolerance": tuple(
                None if sd is None else _arrays.number(key, sd)
                for key, sd in (("gain_sd", gain_sd), ("delay_sd_s", delay_sd_s), ("nut_sd_m", nut_sd_m))
            ),
            "fit": None if fit is None else _arrays.names("fit", fit),
            "nut_m": {
                position: None
                if at is None
                else _arrays.number(f"nut_m[{position!r}]", at, "give a distance in m")
                for position, at in _arrays.optional_mapping("nut_m", nut_m).items()
            },
        }
        if isinstance(frfs, Mapping):
            records = _by_position(frequency_hz, frfs, coherence, relative_sd)
        else:
            records = [_record(at, record) for at, record in enumerate(frfs)]
        for key, remedy in (
            ("quantity", "receptance, mobility or accelerance"),
            ("response", "the point of the machine"),
            ("excitation", "the point of the machine"),
        ):
            if given[key] is None and any(record[key] is None for record in records):
                raise argument(key, f"is missing; give {remedy}")
        if given["averages"] is None and any(
            record["coherence"] is not None and record["averages"] is None for record in records
        ):
            raise argument(
                "averages", "is missing, without which a coherence says nothing; give the number of averages"
            )
        moves = [
            _motion(record, arrays) for record, arrays in _arrays.optional_mapping("motions", motions).items()
        ]
        if not records and not moves:
            raise argument("frfs", "holds nothing; give one complex array a position, or motions")
        core = _core.MeasurementSet.from_arrays(given, records, moves)
        return cls._of(core, (given, records, moves))

    @property
    def path(self) -> str:
        """Folder of the set, or its name."""
        return self._core.path

    @property
    def title(self) -> str:
        """Title of the set."""
        return self._core.title

    @property
    def warnings(self) -> list[str]:
        """Warnings about the set, and what an import assumed or left out."""
        return self._core.warnings

    @property
    def nut_m(self) -> dict[str, float | None]:
        """Positions in order, each with its nut position (m)."""
        return dict(self._core.positions)

    @property
    def frfs(self) -> dict[str, Frf]:
        """FRFs by position, else by record; channel and number are added where names would not be unique."""
        found = [Frf(**self._core.frf(at)) for at in range(self._core.frfs)]
        plain = [frf.position or frf.record or f"frf {at + 1}" for at, frf in enumerate(found)]
        full = [f"{name} {frf.response}/{frf.excitation}" for name, frf in zip(plain, found, strict=True)]
        for names in (plain, full, [f"{name} {at + 1}" for at, name in enumerate(full)]):
            if len(set(names)) == len(names):
                return dict(zip(names, found, strict=True))
        raise AssertionError("numbered names are unique")

    @property
    def modes(self) -> list[dict[str, Any]]:
        """Observed modes: `position`, `order`, `frequency_hz`, `amplitude`."""
        keys = ("position", "order", "frequency_hz", "amplitude")
        return [dict(zip(keys, row, strict=True)) for row in self._core.modes]

    @property
    def motions(self) -> list[str]:
        """Names of the motion records."""
        return self._core.motions

    def to_uff(
        self, path: str | os.PathLike[str], *, binary: bool = True, replace: bool = False
    ) -> list[str]:
        """Writes the FRFs as a universal file (dataset 58b, or 58 as text); returns what such a file cannot hold."""
        content, notes = self._core.universal(binary)
        write(path, content, replace=replace)
        return notes

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Writes the set into a folder, which the command and other programs read: `manifest.toml` and tables.

        Raises
        ------
        InputError
            The folder has a manifest already, or cannot be written; nothing is written then.
        """
        target = Path(_arrays.path("folder", folder))
        files = self._files()
        outside = [name for name in files if Path(name).is_absolute() or ".." in Path(name).parts]
        if outside:
            raise InputError(
                f"{target}: {outside[0]} lies outside the set's folder; copy it into the folder first",
                file=str(target),
                key="folder",
            )
        # The manifest is the first to leave and the last to come: a folder without one is no set.
        whole = sorted(files.items(), key=lambda file: file[0] != "manifest.toml")
        _core.write_files(target, whole, True)
        return target

    def _files(self) -> dict[str, bytes]:
        if self._arrays is None:
            return dict(self._core.files())
        from ._folder import files_of_arrays

        return files_of_arrays(*self._arrays)

    def __reduce__(self):
        if self._arrays is None:
            return _from_files, (self.path, dict(self._core.files()))
        return _from_arrays, self._arrays

    def __repr__(self) -> str:
        counted = [
            (self._core.frfs, "FRFs"),
            (len(self._core.modes), "modes"),
            (len(self.motions), "motion records"),
        ]
        return f"MeasurementSet({self.path!r}: {', '.join(f'{n} {what}' for n, what in counted if n) or 'empty'})"


def read_uff(
    files: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    quantity: str | None = None,
    averages: int | None = None,
    response: str | None = None,
    excitation: str | None = None,
    nut_m: Mapping[str, float] | None = None,
    position: str | None = None,
    pattern: str | None = None,
    map: str | os.PathLike[str] | None = None,
    strict: bool = False,
    accept_truncated: bool = False,
    title: str | None = None,
) -> MeasurementSet:
    """Reads universal files (dataset 58 and 58b) as a measurement set.

    Parameters
    ----------
    files : path or list of paths
    quantity : {"receptance", "mobility", "accelerance"}
        Measured quantity, where the file does not state it.
    averages : int
        Number of averages, which no universal file states; needed to use a coherence.
    response, excitation : str
        Points of the machine; those of the file where absent.
    nut_m : mapping of position to float
        Nut positions (m).
    position : str
        Position of all records.
    pattern : str
        Pattern with {} for the position's name, in file names, ID lines or entities.
    map : path
        Table with the columns record,position,response,excitation.
    strict : bool
        Whether any faulty part refuses its file; otherwise sound parts are read, and `warnings` names the rest.
    accept_truncated : bool
        Whether files that end inside their data are accepted.

    Raises
    ------
    InputError
        A file cannot be read or holds no FRF, or names do not fit its records.
    """
    return _imported(
        files,
        None,
        quantity,
        averages,
        response,
        excitation,
        nut_m,
        position,
        pattern,
        map,
        strict,
        accept_truncated,
        title,
    )


def read_tables(
    files: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    columns: Sequence[str] | None = None,
    quantity: str | None = None,
    averages: int | None = None,
    response: str | None = None,
    excitation: str | None = None,
    nut_m: Mapping[str, float] | None = None,
    position: str | None = None,
    pattern: str | None = None,
    map: str | os.PathLike[str] | None = None,
    title: str | None = None,
) -> MeasurementSet:
    """Reads FRFs from tables of other programs (.csv, .tsv, .txt, .dat, .asc); `columns` names their columns in place of a header. Else as
    :func:`read_uff`."""
    named = None if columns is None else _arrays.names("columns", columns)
    return _imported(
        files,
        named,
        quantity,
        averages,
        response,
        excitation,
        nut_m,
        position,
        pattern,
        map,
        True,
        False,
        title,
    )


def _imported(
    files: Any,
    columns: list[str] | None,
    quantity: Any,
    averages: Any,
    response: Any,
    excitation: Any,
    nut_m: Any,
    position: Any,
    pattern: Any,
    map: Any,
    strict: bool,
    accept_truncated: bool,
    title: Any,
) -> MeasurementSet:
    several = [files] if isinstance(files, (str, os.PathLike)) else list(files)
    if not several:
        raise argument("files", "is empty; name at least one file")
    paths = [_arrays.path("files", file) for file in several]
    given = {
        "files": paths,
        "columns": columns,
        "strict": bool(strict),
        "accept_truncated": bool(accept_truncated),
        "quantity": _arrays.optional_name("quantity", quantity),
        "position": _arrays.optional_name("position", position),
        "pattern": _arrays.optional_name("pattern", pattern),
        "map": None if map is None else _arrays.path("map", map),
        "nut_m": {
            at: _arrays.number(f"nut_m[{at!r}]", x) for at, x in _arrays.optional_mapping("nut_m", nut_m).items()
        },
        "response": _arrays.optional_name("response", response),
        "excitation": _arrays.optional_name("excitation", excitation),
        "averages": _arrays.optional_count("averages", averages, 1),
        "title": _arrays.optional_name("title", title) or Path(paths[0]).stem,
    }
    return MeasurementSet._of(_core.MeasurementSet.import_files(given))


def _gain(gain: float | str) -> float | None:
    if isinstance(gain, str):
        if gain != "unknown":
            raise argument("gain", f'is {gain!r}; give a number above 0, or "unknown"')
        return None
    value = _arrays.number("gain", gain, 'give a number above 0, or "unknown"')
    if value <= 0:
        raise argument("gain", f'is {value}; give a number above 0, or "unknown"')
    return value


# Keys of an FRF that a mapping may have beside its arrays, with their checks.
_OF_RECORD = {
    "position": _arrays.optional_name,
    "record": _arrays.optional_name,
    "response": _arrays.optional_name,
    "excitation": _arrays.optional_name,
    "quantity": _arrays.optional_name,
    "averages": lambda key, given: _arrays.optional_count(key, given, 1),
    "force_n": lambda key, given: None if given is None else _arrays.number(key, given),
    "speed_m_s": lambda key, given: None if given is None else _arrays.number(key, given),
    "acceleration_m_s2": lambda key, given: None if given is None else _arrays.number(key, given),
}
_NOISE = ("coherence", "relative_sd")


def _by_position(frequency_hz: Any, frfs: Any, coherence: Any, relative_sd: Any) -> list[dict[str, Any]]:
    values = _arrays.mapping("frfs", frfs)
    if frequency_hz is None:
        raise argument("frequency_hz", "is missing; give the frequencies of the FRFs in Hz")
    common = None if isinstance(frequency_hz, Mapping) else _arrays.frequencies("frequency_hz", frequency_hz)
    noise = {
        key: _arrays.optional_mapping(key, given)
        for key, given in (("coherence", coherence), ("relative_sd", relative_sd))
    }
    for key, given in noise.items():
        _arrays.unknown(key, given, values)
    records = []
    for position, value in values.items():
        own: dict[str, Any] = {"position": position, "value": value}
        if common is None:
            by_position = _arrays.mapping("frequency_hz", frequency_hz)
            if position not in by_position:
                raise argument("frequency_hz", f"has no «{position}»; give the frequencies of every position")
            own["frequency_hz"] = by_position[position]
        else:
            own["frequency_hz"] = common
        own |= {key: given[position] for key, given in noise.items() if position in given}
        label = repr(position)
        key_of = "frequency_hz" if common is not None else f"frequency_hz[{label}]"
        names = {"value": f"frfs[{label}]", "frequency_hz": key_of} | {
            key: f"{key}[{label}]" for key in _NOISE
        }
        records.append(_checked(own, names))
    return records


def _record(at: int, record: Any) -> dict[str, Any]:
    own = _arrays.mapping(f"frfs[{at}]", record)
    known = [*_OF_RECORD, "frequency_hz", "value", *_NOISE]
    _arrays.unknown(f"frfs[{at}]", own, known)
    for key in ("frequency_hz", "value"):
        if own.get(key) is None:
            raise argument(
                f"frfs[{at}]", f"has no {key}; give its frequencies (Hz) as frequency_hz and the FRF as value"
            )
    return _checked(own, {key: f"frfs[{at}][{key!r}]" for key in known})


def _checked(own: dict[str, Any], names: dict[str, str]) -> dict[str, Any]:
    lines = _arrays.frequencies(names["frequency_hz"], own["frequency_hz"])
    made: dict[str, Any] = {
        key: check(names.get(key, key), own.get(key)) for key, check in _OF_RECORD.items()
    }
    made |= {"frequency_hz": lines, "value": _arrays.complex_array(names["value"], own["value"])}
    made |= {
        key: None if own.get(key) is None else _arrays.real_array(names[key], own[key]) for key in _NOISE
    }
    for key in ("value", *_NOISE):
        if made[key] is not None:
            _arrays.same_length(names[key], made[key], names["frequency_hz"], lines.size)
            made[key] = _arrays.own(made[key])
    return made | {"frequency_hz": _arrays.own(lines)}


def _motion(record: str, given: Any) -> dict[str, Any]:
    label = f"motions[{record!r}]"
    arrays = {
        key: _arrays.own(_arrays.real_array(f"{label}[{key!r}]", array))
        for key, array in _arrays.mapping(label, given).items()
    }
    efforts = [key for key in ("force_n", "torque_nm") if key in arrays]
    missing = [key for key in ("time_s", "command_m", "position_m") if key not in arrays]
    if missing or len(efforts) != 1:
        raise argument(
            label,
            f"has {', '.join(arrays) or 'nothing'}; give time_s, command_m, position_m and one of force_n and torque_nm",
        )
    for key, array in arrays.items():
        _arrays.same_length(f"{label}[{key!r}]", array, f"{label}['time_s']", arrays["time_s"].size)
    made: dict[str, Any] = {key: arrays.pop(key) for key in ("time_s", "command_m", "position_m")}
    return made | {
        "name": record,
        "effort": arrays.pop(efforts[0]),
        "is_torque": efforts[0] == "torque_nm",
        "others": arrays,
    }


def _from_files(path: str, files: dict[str, bytes]) -> MeasurementSet:
    return MeasurementSet._of(_core.MeasurementSet.from_files(path, files))


def _from_arrays(
    given: dict[str, Any], records: list[dict[str, Any]], moves: list[dict[str, Any]]
) -> MeasurementSet:
    # A pickle that was sent may lie unaligned in memory.
    def whole(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: whole(entry) for key, entry in value.items()}
        return _arrays.whole(value) if isinstance(value, np.ndarray) else value

    records, moves = [whole(record) for record in records], [whole(move) for move in moves]
    return MeasurementSet._of(
        _core.MeasurementSet.from_arrays(given, records, moves), (given, records, moves)
    )


def write(path: str | os.PathLike[str], content: bytes | str, *, replace: bool = False) -> None:
    """Writes a file as a whole. An existing one is replaced where jointid wrote it, or on request."""
    target = Path(_arrays.path("path", path))
    content = content.encode() if isinstance(content, str) else content
    _core.write_files(target.parent, [(target.name, content)], False, replace)
