"""Measurement sets: from folders, arrays, universal files and tables."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _core, _html
from ._errors import InputError, argument
from ._records import frf_record, frfs_by_position, gain_of, motion_record, require_channel

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class Frf:
    """A measured FRF, H = response / force with e^{+iωt}; lines whose coherence is too low are left out.

    `frequency_hz` has the shape (lines,), in Hz; `value` (lines,), complex, in m/N, (m/s)/N or (m/s²)/N by `quantity`; `coherence` and `relative_sd`
    (standard deviation of the complex mean over |H|) are (lines,) where stated.

    >>> taps.frfs["p1"].value.dtype
    dtype('complex128')
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

    Examples
    --------
    >>> jd.MeasurementSet("measurements/tian").nut_m["l1"]
    0.6
    """

    def __init__(self, folder: str | os.PathLike[str], *, allow_outside: bool = False) -> None:
        self._core = _core.MeasurementSet.read(_arrays.path("folder", folder), allow_outside)
        self._arrays: tuple[Any, ...] | None = None
        self._in_memory = False

    @classmethod
    def of(cls, given: MeasurementSet | str | os.PathLike[str]) -> MeasurementSet:
        """A set as it is, or the one of a folder.

        >>> jd.MeasurementSet.of(taps) is taps
        True
        """
        return given if isinstance(given, MeasurementSet) else cls(given)

    @classmethod
    def _of(
        cls, core: _core.MeasurementSet, arrays: tuple[Any, ...] | None = None, in_memory: bool = True
    ) -> MeasurementSet:
        made = cls.__new__(cls)
        made._core, made._arrays, made._in_memory = core, arrays, in_memory
        return made

    @property
    def in_memory(self) -> bool:
        """Whether it was made of arrays, or read from files of other programs: no folder holds it unless it is saved."""
        return self._in_memory

    @classmethod
    def from_files(cls, files: Mapping[str, bytes | str], name: str = "measurements") -> MeasurementSet:
        """Reads a set from the contents of its files by name, `manifest.toml` among them; `name` stands for its folder in messages and documents.

        >>> manifest = 'title = "one"\\nquantity = "receptance"\\nresponse = "table"\\nexcitation = "table"\\nmodes = "modes.csv"\\n[[position]]\\nname = "p"\\nnut_m = 0.6\\n'
        >>> modes = "position,order,frequency_hz,amplitude\\np,1,24.0,\\n"
        >>> jd.MeasurementSet.from_files({"manifest.toml": manifest, "modes.csv": modes}).modes[0]["frequency_hz"]
        24.0
        """
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

        Examples
        --------
        >>> f = np.linspace(8.0, 400.0, 100)
        >>> H = machine.frf(f, nut_m=0.6, response="table", excitation="table")
        >>> jd.MeasurementSet.from_arrays(
        ...     f, {"p1": H}, nut_m={"p1": 0.6}, quantity="receptance", response="table", excitation="table"
        ... )
        MeasurementSet('arrays (...)': 1 FRFs)
        """
        given = {
            "title": _arrays.name("title", title),
            "quantity": _arrays.optional_name("quantity", quantity),
            "response": _arrays.optional_name("response", response),
            "excitation": _arrays.optional_name("excitation", excitation),
            "averages": _arrays.optional_count("averages", averages, 1),
            "gain": gain_of(gain),
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
            records = frfs_by_position(frequency_hz, frfs, coherence, relative_sd)
        else:
            records = [frf_record(at, record) for at, record in enumerate(frfs)]
        require_channel(given, records)
        moves = [
            motion_record(record, arrays) for record, arrays in _arrays.optional_mapping("motions", motions).items()
        ]
        if not records and not moves:
            raise argument("frfs", "holds nothing; give one complex array a position, or motions")
        core = _core.MeasurementSet.from_arrays(given, records, moves)
        return cls._of(core, (given, records, moves))

    @classmethod
    def from_frame(cls, frame: pandas.DataFrame, **given: Any) -> MeasurementSet:
        """Makes a set of a table with one row a line, as :meth:`to_frame` has it.

        Its columns are `frequency_hz` and `value` (complex), or `real` and `imag`; and as needed `position`, `record`, `response`, `excitation`, `quantity`,
        `averages`, `coherence`, `relative_sd`. Rows of like position, record, response and excitation are one FRF. `given` are other arguments of
        :meth:`from_arrays`.

        >>> again = jd.MeasurementSet.from_frame(taps.to_frame(), nut_m=taps.nut_m)
        >>> bool((again.frfs["p1"].value == taps.frfs["p1"].value).all())
        True
        """
        from ._frames import records_of_frame

        return cls.from_arrays(None, records_of_frame(frame), **given)

    def to_frame(self) -> pandas.DataFrame:
        """The FRFs as a table with one row a line: position, record, response, excitation, quantity, averages, frequency_hz, value, coherence, relative_sd.

        >>> list(taps.to_frame())[:2]
        ['position', 'record']
        """
        from ._frames import frame_of_frfs

        return frame_of_frfs(self.frfs.values())

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
        """Writes the FRFs as a universal file (dataset 58b, or 58 as text); returns what such a file cannot hold.

        >>> notes = taps.to_uff("taps.uff", binary=False, replace=True)
        """
        content, notes = self._core.universal(binary)
        write(path, content, replace=replace)
        return notes

    def save(self, folder: str | os.PathLike[str], *, replace: bool = False) -> Path:
        """Writes the set into a folder, which the command and other programs read: `manifest.toml` and tables.

        >>> taps.save("taps", replace=True).name
        'taps'

        Raises
        ------
        InputError
            The folder has a manifest already and `replace` is not given, or cannot be written; nothing is written then.
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
        _core.write_files(target, whole, not replace, replace)
        return target

    def _files(self) -> dict[str, bytes]:
        if self._arrays is None:
            return dict(self._core.files())
        from ._folder import files_of_arrays

        return files_of_arrays(*self._arrays)

    def __reduce__(self) -> tuple[Any, ...]:
        if self._arrays is None:
            return _from_files, (self.path, dict(self._core.files()), self._in_memory)
        return _from_arrays, self._arrays

    def _repr_html_(self) -> str:
        rows = [
            (
                name,
                f"{frf.response}/{frf.excitation}",
                frf.quantity,
                str(frf.frequency_hz.size),
                f"{frf.frequency_hz[0]:g} … {frf.frequency_hz[-1]:g}" if frf.frequency_hz.size else "",
                f"{np.abs(frf.value).min():.3g} … {np.abs(frf.value).max():.3g}" if frf.value.size else "",
            )
            for name, frf in self.frfs.items()
        ]
        columns = ("FRF", "response/excitation", "quantity", "lines", "frequency  Hz", "|H|  SI")
        named = {"positions": ", ".join(f"{name} at {at} m" for name, at in self.nut_m.items())}
        named |= {"motion records": ", ".join(self.motions)} if self.motions else {}
        parts = [_html.pairs(named), *([_html.table(columns, rows)] if rows else [])]
        return _html.page("MeasurementSet", f"{self.title} ({self.path})", parts, self.warnings)

    def __repr__(self) -> str:
        counted = [
            (self._core.frfs, "FRFs"),
            (len(self._core.modes), "modes"),
            (len(self.motions), "motion records"),
        ]
        return f"MeasurementSet({self.path!r}: {', '.join(f'{n} {what}' for n, what in counted if n) or 'empty'})"


def _from_files(path: str, files: dict[str, bytes], in_memory: bool) -> MeasurementSet:
    return MeasurementSet._of(_core.MeasurementSet.from_files(path, files), in_memory=in_memory)


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
