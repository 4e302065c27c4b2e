"""Arrays of any kind give the same answer in this process, pickled, in a pool, and on Dask.

JOINTID_MACHINES=200 runs as many machines as a study does; by default there is one of each kind.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from conftest import BENCH, taps

import jointid as jd

LINES = np.linspace(8.0, 400.0, 60)
SETTINGS: jd.Settings = {"freeze": ["c_al", "c_ar", "c_n", "c_m", "c_s"], "tolerances": False}
BUFFER = np.empty(LINES.size, complex)


def read_only(x):
    x = x.copy()
    x.setflags(write=False)
    return x


def reused(x):
    BUFFER[:] = x
    return BUFFER


def unaligned(x):
    return np.frombuffer(b"x" + x.tobytes(), dtype=np.uint8)[1:].view(x.dtype)


def mapped(x, folder):
    file = folder / f"{len(list(folder.iterdir()))}.npy"
    np.save(file, x)
    return np.load(file, mmap_mode="r")


KINDS = {
    "as it is": lambda x, _: x,
    "row of an array": lambda x, _: np.stack([x, 2 * x])[0],
    "column in Fortran order": lambda x, _: np.asfortranarray(np.stack([x, 2 * x], axis=1))[:, 0],
    "column in C order": lambda x, _: np.stack([x, 2 * x], axis=1)[:, 0],
    "reversed": lambda x, _: x[::-1].copy()[::-1],
    "single precision": lambda x, _: x.astype(np.complex64),
    "big-endian": lambda x, _: x.astype(">c16"),
    "masked without a mask": lambda x, _: np.ma.masked_array(x),
    "read-only": lambda x, _: read_only(x),
    "reused": lambda x, _: reused(x),
    "unaligned": lambda x, _: unaligned(x),
    "memory-mapped": mapped,
    "subclass": lambda x, _: x.view(type("Own", (np.ndarray,), {})),
    "list": lambda x, _: x.tolist(),
}


def of_kind(kind: str, at: int, folder) -> tuple[jd.MeasurementSet, jd.MeasurementSet]:
    """A set of arrays of a kind, and that of plain arrays with the same numbers."""
    exact = {name: frf.value for name, frf in taps(4e8 * (1 + at / 500), at, 0.01, LINES).frfs.items()}
    if kind == "single precision":
        exact = {name: value.astype(np.complex64).astype(complex) for name, value in exact.items()}
    nut_m = {"p1": 0.6, "p2": 1.2, "p3": 1.8}
    records = [
        {"position": name, "frequency_hz": LINES, "value": KINDS[kind](value.copy(), folder)}
        for name, value in exact.items()
        if kind != "reused"
    ]
    if kind == "reused":
        # Each FRF is a set of its own before the buffer holds the next one.
        sets = [
            jd.MeasurementSet.from_arrays(LINES, {name: reused(value)}, nut_m={name: nut_m[name]}, **BENCH)
            for name, value in exact.items()
        ]
        BUFFER[:] = 1.0
        read = [next(iter(of.frfs.values())) for of in sets]
        records = [
            {"position": frf.position, "frequency_hz": frf.frequency_hz, "value": frf.value} for frf in read
        ]
    common = {"nut_m": nut_m, "title": f"m{at}", **BENCH}
    return (
        jd.MeasurementSet.from_arrays(None, records, **common),
        jd.MeasurementSet.from_arrays(LINES, exact, **common),
    )


def answer(of: jd.MeasurementSet) -> str:
    return jd.Study(None, of).choose_fit(["p1", "p3"]).identify(progress=False, **SETTINGS).json


def test_every_kind_of_array_gives_the_same_answer_everywhere(tmp_path):
    count = int(os.environ.get("JOINTID_MACHINES", str(len(KINDS))))
    kinds = [list(KINDS)[at % len(KINDS)] for at in range(count)]
    made = [of_kind(kind, at, tmp_path) for at, kind in enumerate(kinds)]
    plain = {f"m{at}": answer(exact) for at, (_, exact) in enumerate(made)}
    sets = {f"m{at}": own for at, (own, _) in enumerate(made)}
    answers = {
        "in this process": {name: answer(of) for name, of in sets.items()},
        "pickled": {name: answer(pickle.loads(pickle.dumps(of))) for name, of in sets.items()},
    }
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as executor:
        answers["in a pool"] = of_fleet(tmp_path / "pool", sets, executor)
    pytest.importorskip("distributed")
    answers["on Dask"] = of_fleet(tmp_path / "dask", sets, None)
    differ = [
        (where, name, kinds[int(name[1:])])
        for where, of in answers.items()
        for name in sets
        if of[name] != plain[name]
    ]
    print(f"{count} machines of {len(KINDS)} kinds: {len(differ)} of {len(answers) * count} answers differ")
    assert differ == []


def of_fleet(folder, sets, client) -> dict[str, str]:
    fleet = jd.Fleet(folder, None, sets, fit=["p1", "p3"], **SETTINGS)
    assert fleet.run(client, workers=None if client else 2).failures == ()
    return {name: document.json for name, document in fleet.documents()}
