"""Every public class, function and method has an example, and the examples run."""

from __future__ import annotations

import doctest
import inspect
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from functools import cache

import numpy as np
import pytest
from conftest import NUTS, taps

import jointid as jd

pytest.importorskip("matplotlib").use("Agg")
pytest.importorskip("pandas")


def public() -> dict[str, object]:
    """Public classes, functions and methods by their names; properties belong to the example of their class."""
    found: dict[str, object] = {"jointid": jd}
    for name in jd.__all__:
        made = getattr(jd, name)
        if inspect.isfunction(made) or inspect.isclass(made):
            found[name] = made
        if inspect.isclass(made):
            methods = {
                method: member.__func__ if isinstance(member, classmethod) else member
                for method, member in vars(made).items()
                if not method.startswith("_") and isinstance(member, (classmethod, staticmethod, type(public)))
            }
            found |= {f"{name}.{method}": member for method, member in methods.items()}
    return found


PUBLIC = public()
# Errors are raised, not made.
WITHOUT = {"InputError", "StoppedError"}


@cache
def names(folder) -> dict[str, object]:
    """Objects that the examples name, as the docstring of the package lists them."""
    study = jd.Study().choose_fit(["l1", "l3", "l5"])
    of_taps = jd.Study("configs/tian.toml", taps(4e8, 1)).choose_fit(["p1", "p3"])
    table = folder / "friction.csv"
    speeds = np.linspace(0.01, 0.5, 25)
    rows = (f"{v},{20 + 200 * v + 3 * np.exp(-v / 0.03)}" for v in speeds)
    table.write_text("velocity_m_s,force_n\n" + "\n".join(rows) + "\n")
    return {
        "jd": jd,
        "np": np,
        "study": study,
        "found": study.identify(),
        "taps": taps(4e8, 1),
        "of_taps": of_taps.identify(),
        "diagnosis": study.without("rotor-hold").diagnose(),
        "machine": jd.Machine("configs/tian.toml"),
        "drive": jd.Machine("configs/emps.toml"),
        "friction_table": table,
    }


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("examples")


@pytest.fixture(scope="module")
def executor():
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as made:
        yield made


@pytest.mark.parametrize("name", [name for name in PUBLIC if name not in WITHOUT])
def test_examples_run(name, folder, executor, monkeypatch):
    monkeypatch.chdir(folder)
    text = inspect.getdoc(PUBLIC[name]) or ""
    test = doctest.DocTestParser().get_doctest(text, names(folder).copy(), name, None, 0)
    assert test.examples, f"{name} has no example"
    of_fleets = {"Fleet", "FleetRun", "coverage", "blind_check"}
    if name.partition(".")[0] in of_fleets:
        fleet = jd.Fleet("fleet", "configs/tian.toml", {"axis 1": taps(4e8, 1), "axis 2": taps(5e8, 2)}, fit=["p1", "p3"])
        fleet.run(executor)
        test.globs |= {"fleet": fleet, "executor": executor}
    said: list[str] = []
    ran = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(test, out=said.append)
    assert ran.failed == 0, "".join(said)
    assert set(NUTS)


def test_the_docstrings_of_the_package_state_what_their_examples_name():
    assert all(f"`{name}`" in (jd.__doc__ or "") for name in ("taps", "of_taps", "diagnosis", "machine", "drive"))
