"""Trials of the method on simulated machines: coverage of the intervals, and the blind check of the diagnosis."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays
from ._errors import InputError
from ._optional import pandas_for
from ._progress import Callback, progress_of
from ._settings import checked
from ._tasks import Task, do, key_of, prepare, result_file
from .machine import Machine
from .measurement import MeasurementSet
from .results import Document
from .study import Study

if TYPE_CHECKING:
    import pandas


Path_ = str | os.PathLike[str]


def coverage(
    folder: Path_,
    machine: Machine | Path_,
    nut_m: Mapping[str, float],
    frequency_hz: ArrayLike,
    *,
    response: str,
    excitation: str,
    draws: int = 100,
    noise: float = 0.01,
    spread: float = 0.3,
    seed: int = 1,
    client: Any = None,
    workers: int | None = None,
    progress: bool | Callback | None = None,
    **settings: Any,
) -> pandas.DataFrame:
    """How often the 95 % intervals of a planned test hold the truth: a study on simulated machines of the description itself.

    Every draw is a machine whose free parameters lie within a factor ``exp(±spread)`` about their start values, clipped to their ranges, tested at the
    positions `nut_m` (m) with noise of the relative standard deviation `noise`, and identified. The truth obeys the model: what a real machine has
    beside it is not in these figures. Masses and diameters are exactly as described, so tolerances are held unless `tolerances=True` is given.

    Returns
    -------
    DataFrame with one row a draw and parameter: draw, parameter, truth, value, low, high, identifiable, holds.

    Examples
    --------
    >>> planned = {"p1": 0.6, "p2": 1.8}
    >>> channel = {"response": "table", "excitation": "table"}
    >>> rows = jd.coverage("coverage", machine, planned, np.linspace(8, 400, 60), draws=2, client=executor, **channel)
    >>> rows["draw"].nunique()
    2
    """
    target = prepare(Path(_arrays.path("folder", folder)))
    described = machine if isinstance(machine, Machine) else Machine(machine)
    lines = _arrays.frequencies("frequency_hz", frequency_hz)
    nuts = {
        name: _arrays.number(f"nut_m[{name!r}]", at) for name, at in _arrays.mapping("nut_m", nut_m).items()
    }
    points = (_arrays.name("response", response), _arrays.name("excitation", excitation))
    sizes = (_arrays.number("noise", noise), _arrays.number("spread", spread))
    kept = {"tolerances": False} | checked(settings)
    first, count = _arrays.count("seed", seed), _arrays.count("draws", draws, 1)

    def tasks() -> Iterator[Task]:
        for at in range(count):
            arguments = (described, nuts, lines, points, sizes, kept, first + at)
            parts = (
                described.path,
                described.text,
                sorted(nuts.items()),
                lines.tobytes(),
                points,
                sizes,
                sorted(kept.items()),
                first + at,
            )
            yield Task(f"draw {at}", key_of("coverage", *parts), _covered, arguments)

    with progress_of(progress, "coverage") as callback:
        did = do(target, tasks(), client, workers=workers, progress=callback, of=count)
    if did.failures:
        raise InputError(
            f"{did.failures[0].name}: {did.failures[0].message}",
            did.failures[0].file,
            did.failures[0].line,
            did.failures[0].key,
        )
    rows = []
    for at, task in enumerate(tasks()):
        rows += [
            {"draw": at} | row
            for row in json.loads(result_file(target, task.key).read_text(encoding="utf-8"))
        ]
    return pandas_for("a table").DataFrame(rows)


def _covered(
    machine: Machine,
    nuts: dict[str, float],
    lines: np.ndarray,
    points: tuple[str, str],
    sizes: tuple[float, float],
    settings: dict[str, Any],
    seed: int,
) -> str:
    """One draw of a study of coverage, in a worker."""
    noise, spread = sizes
    generator = np.random.default_rng(seed)
    frozen = settings.get("freeze", ())
    truth = {}
    for name, described in machine.parameters.items():
        if name not in frozen and described.start > 0:
            drawn_value = described.start * np.exp(generator.uniform(-spread, spread))
            truth[name] = float(np.clip(drawn_value, described.lower, described.upper))
    common: dict[str, Any] = {"response": points[0], "excitation": points[1], "quantity": "receptance"}
    empty = MeasurementSet.from_arrays(
        lines, {name: np.ones(lines.size, complex) for name in nuts}, nut_m=nuts, **common
    )
    simulated = Study(
        machine, empty, overrides={f"parameter.{name}.start": value for name, value in truth.items()}
    )
    values = simulated.frf(lines, nut_m=list(nuts.values()))
    drawn = generator.normal(size=(2, *values.shape)) * noise / np.sqrt(2)
    measured = values * (1 + drawn[0] + 1j * drawn[1])
    relative_sd = {name: np.full(lines.size, noise) for name in nuts}
    taps = MeasurementSet.from_arrays(
        lines, dict(zip(nuts, measured, strict=True)), relative_sd=relative_sd, nut_m=nuts, **common
    )
    found = Study(machine, taps).identify(seed=seed, threads=1, progress=False, **settings)
    rows = []
    for name, parameter in found.parameters.items():
        if not parameter.fitted or name not in truth:
            continue
        parts = parameter.intervals95 or ((parameter.interval95,) if parameter.interval95 else ())
        low, high = parameter.interval95 or (None, None)
        row = {"parameter": name, "truth": truth[name], "value": parameter.value, "low": low, "high": high}
        row |= {"identifiable": parameter.identifiable, "holds": any(a <= truth[name] <= b for a, b in parts)}
        rows.append(row)
    return json.dumps(rows)


def blind_check(
    folder: Path_,
    *,
    cases: int | str = "quick",
    seed: int = 1,
    arm: str = "frf",
    layout: str | None = None,
    client: Any = None,
    workers: int | None = None,
    progress: bool | Callback | None = None,
) -> Document:
    """The blind check of the diagnosis (`jointid lab withheld`) on a cluster: cases are made and sealed here, diagnosed there, and scored here.

    It needs the program `jointid-lab`, which is no part of the package: `cargo install --path src/lab` in a clone of the project.

    `cases` is a number, "quick" or "full"; `arm` "frf" or "motion"; `layout` "all" or the name of one, for hammer tests.
    All workers must see `folder`. Returns the document `withheld.json`.

    >>> jd.blind_check("blind", cases=2, client=executor)["complete"]                   # doctest: +SKIP
    True
    """
    target = prepare(Path(_arrays.path("folder", folder)))
    place = ["--out", str(target / "cases")]
    chosen = [
        "--cases",
        str(cases),
        "--seed",
        str(_arrays.count("seed", seed)),
        "--arm",
        _arrays.name("arm", arm),
    ]
    if layout is not None:
        chosen += ["--layout", _arrays.name("layout", layout)]
    seal = json.loads(_command(["lab", "withheld", *place, *chosen, "--cases-only", "--json", "--quiet"]))
    names = [case["name"] for case in seal["cases"]]
    tasks = (
        Task(name, key_of("blind check", chosen, name, case["sha256"]), _answered, (place, name))
        for name, case in zip(names, seal["cases"], strict=True)
    )
    with progress_of(progress, "blind check") as callback:
        did = do(target, tasks, client, workers=workers, progress=callback, of=len(names))
    if did.failures:
        raise InputError(f"{did.failures[0].name}: {did.failures[0].message}", file=str(target))
    return Document(_command(["lab", "withheld", *place, "--json", "--quiet"]))


def _answered(place: list[str], name: str) -> str:
    """Diagnoses one case in a worker; the answer is kept in the folder of the cases."""
    _command(["lab", "withheld", *place, "--case", name, "--jobs", "1", "--quiet"])
    return "{}"


def _command(words: list[str]) -> str:
    """Runs the command of this package in a process of its own; returns what it prints."""
    import subprocess

    environment = os.environ | {
        "RAYON_NUM_THREADS": os.environ.get("RAYON_NUM_THREADS", "1" if "--case" in words else "")
    }
    if not environment["RAYON_NUM_THREADS"]:
        del environment["RAYON_NUM_THREADS"]
    ran = subprocess.run(
        [sys.executable, "-m", "jointid", *words],
        capture_output=True,
        text=True,
        check=False,
        env=environment,
    )
    if ran.returncode != 0:
        raise InputError(ran.stderr.strip() or f"jointid {' '.join(words[:2])} ended with {ran.returncode}")
    return ran.stdout
