"""Fleets: many machines identified on all cores, on a Dask cluster, or on any executor; interrupted runs go on where they ended."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _arrays, _html
from ._errors import InputError, argument
from ._optional import pandas_for
from ._progress import Callback, progress_of
from ._settings import checked
from ._tasks import Done, Failure, Task, do, key_of, prepare, result_file
from .machine import Machine
from .measurement import MeasurementSet, write
from .identification import Identification
from .parameters import Draws
from .results import Document
from .study import Study

if TYPE_CHECKING:
    import pandas


Path_ = str | os.PathLike[str]
# Draws of a task: enough to outweigh the cost of a task (about 6 ms), few enough that a lost worker costs seconds.
BLOCK = 25


@dataclass(frozen=True)
class FleetRun:
    """What a run did: tasks done now, tasks whose results were there already, failures, and the time it took (s).

    >>> fleet.run(executor).kept
    2
    """

    done: int
    kept: int
    failures: tuple[Failure, ...]
    seconds: float

    @classmethod
    def _of(cls, did: Done) -> FleetRun:
        return cls(did.done, did.kept, tuple(did.failures), did.seconds)


class Fleet:
    """Machines to identify, one document each, with bootstrap draws as rows.

    A task is one machine, or one machine with a block of draws. Its result is a file in `folder`, named by a digest of inputs, settings, seed and build: a
    lost worker, a lost scheduler or a second run costs only what was under way, and changed inputs are computed anew.

    Parameters
    ----------
    folder : path
        Folder of the results, which need not exist.
    machines : path or Machine, or mapping of name to either
        One description for all, or one each.
    measurements : mapping of name to path or MeasurementSet, or path
        Measurement sets by name of the machine, or a folder whose subfolders are sets.
    fit, hold_out : list of str
        Positions or records to fit and to hold out; by default as each set states.
    bootstrap : int
        Draws a machine, besides its identification: a bootstrap over lines of FRFs; from the posterior for modes.
    seed : int
        Seed of searches and draws.
    **settings
        See :class:`jointid.study.Settings`.

    Raises
    ------
    InputError
        The folder cannot be written, or an argument is wrong. A machine with bad input is no error: see :meth:`failures`.

    Examples
    --------
    >>> fleet = jd.Fleet("fleet", "configs/tian.toml", {"axis 1": taps, "axis 2": taps}, fit=["p1", "p3"])
    >>> fleet.names
    ['axis 1', 'axis 2']
    """

    def __init__(
        self,
        folder: Path_,
        machines: Path_ | Machine | Mapping[str, Path_ | Machine] | None,
        measurements: Path_ | Mapping[str, Path_ | MeasurementSet],
        *,
        fit: str | Sequence[str] | None = None,
        hold_out: str | Sequence[str] = (),
        bootstrap: int = 0,
        seed: int = 1,
        **settings: Any,
    ) -> None:
        self.folder = Path(_arrays.path("folder", folder))
        self._sets = _sets(measurements)
        if isinstance(machines, Mapping):
            self._machines = _arrays.mapping("machines", machines)
            _arrays.unknown("measurements", self._sets, self._machines)
        else:
            self._machines = dict.fromkeys(self._sets, machines)
        self._fit = None if fit is None else _arrays.names("fit", fit)
        self._hold_out = _arrays.names("hold_out", hold_out)
        self._bootstrap, self._seed = _arrays.count("bootstrap", bootstrap), _arrays.count("seed", seed)
        self._settings = checked(settings)
        self._failures: dict[str, Failure] = {}
        self._keys: dict[str, str] = {}
        prepare(self.folder)

    @property
    def names(self) -> list[str]:
        """Names of the machines."""
        return list(self._sets)

    def run(
        self,
        client: Any = None,
        *,
        workers: int | None = None,
        security: Any = None,
        progress: bool | Callback | None = None,
    ) -> FleetRun:
        """Does what is not done yet.

        Parameters
        ----------
        client : dask.distributed.Client or concurrent.futures.Executor
            Where the work is done; by default a Dask cluster on this machine, bound to the loopback interface, or processes where Dask is missing. A pool
            of processes must start them by spawn or forkserver; one that breaks, since a process was killed, is replaced by a like one.
        workers : int
            Processes of the default; one a core.
        security : distributed.Security
            TLS of the default cluster.
        progress : bool or function of (stage, done, of)

        Returns
        -------
        FleetRun

        Raises
        ------
        InputError
            The client is closed, or no client; the folder cannot be written any more, such as on a full disk. What was done stays.

        Examples
        --------
        >>> len(fleet.run(executor).failures)
        0
        """
        self._failures, self._keys = {}, {}
        count = _arrays.optional_count("workers", workers, 1)
        of = len(self._sets) * (1 + len(self._blocks()))
        with progress_of(progress, "fleet") as callback:
            did = do(
                self.folder,
                self._tasks(),
                client,
                workers=count,
                security=security,
                then=self._draws_of,
                progress=callback,
                of=of,
            )
        for failure in [*self._failures.values(), *did.failures]:
            self._failures[failure.name] = failure
        return FleetRun(did.done, did.kept, tuple(self._failures.values()), did.seconds)

    def failures(self) -> pandas.DataFrame:
        """Machines that the last run could not identify: name, error, message, file, line and key.

        >>> fleet.failures().empty
        True
        """
        return pandas_for("a table").DataFrame(self._failures.values(), columns=Failure._fields)

    def documents(self) -> Iterator[tuple[str, Document]]:
        """The identifications that are done, by name.

        >>> [name for name, document in fleet.documents()]
        ['axis 1', 'axis 2']
        """
        for name in self._sets:
            file = self._file(name)
            if file is not None and file.exists():
                yield name, Document(file.read_text(encoding="utf-8"))

    def identification(self, name: str) -> Identification:
        """The identification of a machine.

        >>> fleet.identification("axis 2").parameters["k_n"].fitted
        True
        """
        _arrays.unknown("name", [_arrays.name("name", name)], self._sets)
        file = self._file(name)
        if file is None or not file.exists():
            raise argument("name", f"«{name}» is not identified yet; run the fleet, and look at its failures")
        text = file.read_text(encoding="utf-8")
        study = self._study(name)
        return Identification(study._core.identification(text), study)

    def table(self) -> pandas.DataFrame:
        """One row a machine: cost, χ² over degrees of freedom, largest error, warnings, and of every parameter value, interval and `identifiable`.

        >>> list(fleet.table().index)
        ['axis 1', 'axis 2']
        """
        rows = []
        for name, document in self.documents():
            derived = document["derived"]
            freedom = derived.get("degrees_of_freedom")
            row: dict[str, Any] = {"machine": name, "cost": document["cost"]}
            row |= {
                "chi2_per_degree": document["cost"] / freedom if freedom else None,
                "warnings": len(document.warnings),
            }
            row |= {key: value for key, value in derived.items() if key.startswith("largest")}
            for parameter, entry in document["parameters"].items():
                low, high = entry["interval95"] or (None, None)
                row |= {parameter: entry["value"], f"{parameter}_low": low, f"{parameter}_high": high}
                row[f"{parameter}_identifiable"] = entry["identifiable"]
            rows.append(row)
        pandas = pandas_for("a table")
        return pandas.DataFrame(rows).set_index("machine") if rows else pandas.DataFrame()

    def draws(self) -> pandas.DataFrame:
        """One row a draw: machine, draw, minimum, weight, and the value of every parameter, as :class:`jointid.Draws` has them.

        About each minimum of a machine there are as many draws as the fleet's `bootstrap`.

        >>> list(fleet.draws())[:2]
        ['machine', 'draw']
        """
        pandas = pandas_for("a table")
        parts = []
        for name in self._sets:
            first = 0
            for at in range(len(self._blocks())):
                file = self._file(name, at)
                if file is None or not file.exists():
                    continue
                content = json.loads(file.read_text(encoding="utf-8"))
                part = Draws(**content).to_frame()
                part.insert(0, "draw", range(first, first + len(part)))
                part.insert(0, "machine", name)
                first += len(part)
                parts.append(part)
        return (
            pandas.concat(parts, ignore_index=True)
            if parts
            else pandas.DataFrame(columns=["machine", "draw"])
        )

    def to_parquet(self, path: Path_, *, replace: bool = False) -> None:
        """Writes the table as Parquet.

        >>> fleet.to_parquet("fleet.parquet", replace=True)
        """
        import io

        content = io.BytesIO()
        self.table().to_parquet(content)
        write(path, content.getvalue(), replace=replace)

    def _repr_html_(self) -> str:
        done = sum(1 for _ in self.documents())
        counted = {"machines": str(len(self._sets)), "identified": str(done)}
        failed = [(failure.name, failure.error, failure.message) for failure in self._failures.values()]
        parts = [_html.pairs(counted)]
        parts += [_html.table(("machine", "error", "message"), failed)] if failed else []
        return _html.page("Fleet", str(self.folder), parts)

    def _blocks(self) -> list[int]:
        whole, rest = divmod(self._bootstrap, BLOCK)
        return [BLOCK] * whole + ([rest] if rest else [])

    def _key(self, name: str) -> str:
        if name not in self._keys:
            inputs = (*_content_of_machine(self._machines[name]), *_content_of_set(self._sets[name]))
            self._keys[name] = key_of(
                "identify", self._fit, self._hold_out, self._seed, sorted(self._settings.items()), *inputs
            )
        return self._keys[name]

    def _file(self, name: str, block: int | None = None) -> Path | None:
        try:
            key = self._key(name)
        except (InputError, OSError):
            return None
        return result_file(self.folder, key if block is None else key_of(key, block, self._blocks()[block]))

    def _study(self, name: str) -> Study:
        return _study(
            self._machines[name], self._sets[name], self._fit, self._hold_out, self._settings, self._seed
        )

    def _tasks(self) -> Iterator[Task]:
        for name, measurements in self._sets.items():
            try:
                key = self._key(name)
            except (InputError, OSError) as fault:
                at = (
                    (fault.file, fault.line, fault.key)
                    if isinstance(fault, InputError)
                    else (fault.filename, None, None)
                )
                self._failures[name] = Failure(name, type(fault).__name__, str(fault), *at)
                continue
            arguments = (
                self._machines[name],
                measurements,
                self._fit,
                self._hold_out,
                self._settings,
                self._seed,
            )
            yield Task(name, key, _identified, arguments)

    def _draws_of(self, task: Task) -> Iterator[Task]:
        if task.function is not _identified:
            return
        source = str(result_file(self.folder, task.key))
        for at, count in enumerate(self._blocks()):
            # Blocks of one machine draw from unlike seeds; machines from the same, as each alone would.
            yield Task(
                task.name,
                key_of(task.key, at, count),
                _drawn,
                (source, task.arguments, count, self._seed + 1 + at),
            )


def _sets(measurements: Any) -> dict[str, Any]:
    if isinstance(measurements, Mapping):
        found = _arrays.mapping("measurements", measurements)
        if not found:
            raise argument("measurements", "is empty; give at least one measurement set by name")
        for name, given in found.items():
            if not isinstance(given, (str, os.PathLike, MeasurementSet)):
                raise argument(
                    f"measurements[{name!r}]",
                    f"is a {type(given).__name__}; give a folder or a MeasurementSet",
                )
        return found
    folder = Path(_arrays.path("measurements", measurements))
    try:
        found = {
            entry.name: str(entry)
            for entry in sorted(folder.iterdir())
            if (entry / "manifest.toml").is_file()
        }
    except OSError as fault:
        message = f"{folder}: cannot be listed ({fault.strerror or fault}); name a folder of measurement sets"
        raise InputError(message, file=str(folder), key="measurements") from None
    if not found:
        message = f"{folder}: has no subfolder with a manifest.toml; name a folder of measurement sets, or give them by name"
        raise InputError(message, file=str(folder), key="measurements")
    return found


def _content_of_machine(machine: Any) -> tuple[bytes, ...]:
    if machine is None:
        return (b"",)
    if isinstance(machine, Machine):
        return (machine.path.encode(), machine.text.encode())
    path = Path(machine)
    return (str(path).encode(), path.read_bytes() if path.exists() else Machine(path).text.encode())


def _content_of_set(measurements: Any) -> Iterator[bytes]:
    """Contents of the files of a set, without parsing them: the driver of a large fleet only reads."""
    if isinstance(measurements, (str, os.PathLike)) and (folder := Path(measurements)).exists():
        yield str(folder).encode()
        for file in sorted(folder.rglob("*") if folder.is_dir() else [folder]):
            if file.is_file() and not file.name.endswith(".part"):
                yield str(file.relative_to(folder)).encode()
                yield file.read_bytes()
        return
    read = MeasurementSet.of(measurements)
    yield read.path.encode()
    for name, content in sorted(read._files().items()):
        yield name.encode()
        yield content


def _study(
    machine: Any,
    measurements: Any,
    fit: list[str] | None,
    hold_out: list[str],
    settings: dict[str, Any],
    seed: int,
) -> Study:
    study = Study(machine, measurements)
    if fit is not None:
        study = study.choose_fit(fit)
    if hold_out:
        study = study.hold_out(hold_out)
    return study._set(seed, settings)


def _identified(*of_study: Any) -> str:
    """Identifies a machine in a worker."""
    return _study(*of_study).identify(seed=of_study[-1], threads=1, progress=False).json


def _drawn(source: str, of_study: tuple[Any, ...], count: int, seed: int) -> str:
    """Draws machines about an identification in a worker."""
    study = _study(*of_study)
    found = Identification(study._core.identification(Path(source).read_text(encoding="utf-8")), study)
    drawn = found.draws(count, seed=seed, threads=1)
    arrays = {key: getattr(drawn, key).tolist() for key in ("values", "minimum", "weight")}
    return json.dumps({"parameters": drawn.parameters} | arrays)
