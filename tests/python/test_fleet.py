"""Fleets: what is lost with a worker or a scheduler is what was under way, and no more."""

from __future__ import annotations

import errno
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from conftest import NUTS, taps

import jointid as jd

pandas = pytest.importorskip("pandas")
FEW = np.linspace(8.0, 400.0, 60)
# The simulated machines are exactly as described.
SETTINGS = {"freeze": ["c_al", "c_ar", "c_n", "c_m", "c_s"], "tolerances": False}
kills = pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this system has no SIGKILL")
forks = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
K_N = [5e8 * np.exp(x) for x in np.linspace(-0.3, 0.3, 200)]


def sets(count: int) -> dict[str, jd.MeasurementSet]:
    return {f"m{at:03d}": taps(K_N[at * len(K_N) // count], at, 0.01, FEW) for at in range(count)}


def fleet(folder: Path, machines: dict, **options) -> jd.Fleet:
    return jd.Fleet(folder, None, machines, fit=["p1", "p3"], **SETTINGS, **options)


def pool(workers: int = 2) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))


def results(folder: Path) -> list[Path]:
    return sorted((folder / "results").glob("*/*.json"))


@pytest.fixture(scope="module")
def eight(tmp_path_factory):
    """A fleet of eight machines, done without an interruption."""
    made = fleet(tmp_path_factory.mktemp("whole"), sets(8), bootstrap=26)
    with pool() as executor:
        run = made.run(executor)
    assert (run.done, run.kept, run.failures) == (8 * 3, 0, ())
    return made


def test_a_fleet_is_its_machines_one_by_one(eight):
    alone = jd.Study(None, sets(8)["m003"]).choose_fit(["p1", "p3"]).with_settings(**SETTINGS)
    assert eight.identification("m003").json == alone.identify(progress=False).json
    table = eight.table()
    assert list(table.index) == eight.names
    # Noise of 1 % over both components, against a model error of 1 % in each besides: a third.
    assert table["chi2_per_degree"].between(0.2, 0.5).all()
    draws = eight.draws()
    assert set(draws["machine"]) == set(eight.names)
    # As many about each minimum of a machine, and some of these machines have two.
    about = draws.groupby(["machine", "minimum"]).size()
    assert set(about) == {26} and 8 < len(about) <= 16
    assert list(draws[draws["machine"] == "m003"]["draw"]) == list(range((draws["machine"] == "m003").sum()))
    spread = draws[draws["minimum"] == 0].groupby("machine")["k_n"].std() / table["k_n"]
    assert spread.between(1e-4, 0.2).all()


def test_a_second_run_does_nothing_and_a_changed_input_only_its_own(eight, tmp_path):
    begun = {file: file.stat().st_mtime_ns for file in results(eight.folder)}
    with pool() as executor:
        again = fleet(eight.folder, sets(8), bootstrap=26)
        assert (again.run(executor).done, len(begun)) == (0, 24)
        other = sets(8) | {"m000": taps(4.4e8, 99, 0.01, FEW)}
        assert fleet(eight.folder, other, bootstrap=26).run(executor).done == 3
        assert fleet(eight.folder, sets(8), bootstrap=26, seed=2).run(executor).kept == 0
    assert all(file.stat().st_mtime_ns == then for file, then in begun.items())
    eight.to_parquet(tmp_path / "table.parquet")
    assert pandas.read_parquet(tmp_path / "table.parquet").equals(eight.table())


def kill_a_worker(folder: Path, after: int, processes) -> None:
    """Kills a process of a pool by SIGKILL as soon as some results are there."""
    while len(results(folder)) < after:
        time.sleep(0.005)
    os.kill(next(iter(processes())), signal.SIGKILL)


@kills
def test_a_killed_worker_of_a_pool_is_replaced(eight, tmp_path):
    made = fleet(tmp_path, sets(8), bootstrap=26)
    with pool() as executor:
        killer = threading.Thread(target=kill_a_worker, args=(tmp_path, 5, lambda: list(executor._processes)))
        killer.start()
        run = made.run(executor)
        killer.join()
    assert (run.done + run.kept, run.failures) == (24, ())
    assert made.table().equals(eight.table()) and made.draws().equals(eight.draws())


class Deadly(jd.MeasurementSet):
    """A set that ends every other process that opens it, as a machine does that needs more memory than there is."""

    def __init__(self, of: jd.MeasurementSet, driver: int) -> None:
        self.of, self.driver = of, driver

    def __getattr__(self, name: str):
        if os.getpid() != self.driver:
            os.kill(os.getpid(), signal.SIGKILL)
        return getattr(self.of, name)

    def __reduce__(self):
        return Deadly, (self.of, self.driver)


def with_a_broken_and_a_deadly_one(count: int) -> dict[str, jd.MeasurementSet | str]:
    """Machines of which one has no measurements, and one kills each worker that opens it."""
    machines: dict[str, jd.MeasurementSet | str] = dict(sets(count))
    names = list(machines)
    deadly = Deadly(machines[names[count // 2]], os.getpid())
    return machines | {names[1]: "nowhere", names[count // 2]: deadly}


@kills
@pytest.mark.parametrize("where", ["pool", "dask"])
def test_only_the_machine_that_kills_its_worker_is_blamed(where, tmp_path):
    count = int(os.environ.get("JOINTID_MACHINES", "8"))
    made = fleet(tmp_path, with_a_broken_and_a_deadly_one(count))
    if where == "pool":
        with pool() as executor:
            run = made.run(executor)
    else:
        pytest.importorskip("distributed")
        run = made.run(workers=2)
    assert run.done == count - 2
    named = {failure.name: failure.message for failure in run.failures}
    assert set(named) == {made.names[1], made.names[count // 2]}
    assert "nowhere" in named[made.names[1]] and "worker was lost" in named[made.names[count // 2]]


def test_a_full_disk_is_said(tmp_path, monkeypatch):
    made = fleet(tmp_path, sets(3))
    write = Path.write_text

    def full(path, *given, **options):
        if path.suffix == ".part":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(path, *given, **options)

    monkeypatch.setattr(Path, "write_text", full)
    with ThreadPoolExecutor(1) as executor, pytest.raises(jd.InputError, match="No space left") as refused:
        made.run(executor)
    assert refused.value.file == str(tmp_path)
    monkeypatch.undo()
    with ThreadPoolExecutor(1) as executor:
        assert made.run(executor).done == 3


SCRIPT = """
import jointid as jd

fleet = jd.Fleet("fleet", None, {"m": "measurements/tian"}, fit=["l1", "l3", "l5"])
"""


@pytest.mark.parametrize("guard", [False, True])
def test_a_script_without_a_main_guard_is_told_so(guard, tmp_path):
    call = 'if __name__ == "__main__":\n    print(fleet.run(workers=1, progress=False).done)' if guard else "fleet.run()"
    (tmp_path / "script.py").write_text(SCRIPT + call + "\n")
    ran = subprocess.run(
        [sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    if guard:
        assert (ran.returncode, ran.stdout.strip()) == (0, "1"), ran.stderr
    else:
        assert ran.returncode != 0 and 'put it below `if __name__ == "__main__":`' in ran.stderr
        assert len(ran.stderr.splitlines()) <= 10 and ran.stderr.count("Traceback") == 1


FORKED = """
import os, sys
import jointid as jd

study = jd.Study().choose_fit(["l1", "l3", "l5"])
study.identify(progress=False)
pid = os.fork()
if pid == 0:
    study.identify(progress=False, threads=1)
    try:
        study.identify(progress=False)
    except RuntimeError as refused:
        print("spawn" in str(refused), flush=True)
        os._exit(0)
    os._exit(1)
assert os.waitpid(pid, 0)[1] == 0
"""


@forks
def test_a_forked_child_says_that_it_lacks_threads():
    ran = subprocess.run(
        [sys.executable, "-c", FORKED], capture_output=True, text=True, check=False, timeout=600
    )
    assert (ran.returncode, ran.stdout.strip()) == (0, "True"), ran.stderr


@kills
def test_a_killed_worker_of_dask_is_replaced(eight, tmp_path):
    distributed = pytest.importorskip("distributed")
    made = fleet(tmp_path, sets(8), bootstrap=26)
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        pids = client.run(os.getpid).values
        killer = threading.Thread(target=kill_a_worker, args=(tmp_path, 5, pids))
        killer.start()
        run = made.run(client)
        killer.join()
    assert run.failures == () and run.done + run.kept == 24
    assert made.table().equals(eight.table()) and made.draws().equals(eight.draws())
    with pytest.raises(jd.InputError, match="closed"):
        fleet(tmp_path, sets(8), bootstrap=26, seed=3).run(client)


def _scheduler(folder: str) -> None:
    """Runs a fleet on a cluster of its own, until it is killed."""
    fleet(Path(folder), sets(8), bootstrap=26).run(workers=2)


@kills
def test_a_lost_scheduler_costs_what_was_under_way(eight, tmp_path):
    pytest.importorskip("distributed")
    process = multiprocessing.get_context("spawn").Process(target=_scheduler, args=(str(tmp_path),))
    process.start()
    while len(results(tmp_path)) < 4:
        time.sleep(0.01)
    os.kill(process.pid, signal.SIGKILL)
    process.join()
    time.sleep(1.0)
    there = {file: file.stat().st_mtime_ns for file in results(tmp_path)}
    for file in there:
        json.loads(file.read_text())
    made = fleet(tmp_path, sets(8), bootstrap=26)
    with pool() as executor:
        run = made.run(executor)
    assert run.done + run.kept == 24 and run.kept >= 4
    assert all(file.stat().st_mtime_ns == then for file, then in there.items())
    assert made.table().equals(eight.table()) and made.draws().equals(eight.draws())


def test_a_machine_with_bad_input_is_a_row(tmp_path):
    taps(5e8, 1).save(tmp_path / "sets/good")
    taps(5e8, 2).save(tmp_path / "sets/bad")
    table = tmp_path / "sets/bad/frf/2.csv"
    table.write_text(table.read_text().replace("\n", "\n-1,0,0\n", 1))
    made = jd.Fleet(tmp_path / "out", "configs/tian.toml", tmp_path / "sets")
    with pool(1) as executor:
        run = made.run(executor)
    assert (run.done, len(run.failures)) == (1, 1)
    failure = made.failures().iloc[0]
    assert (failure["name"], failure["error"], failure["file"], failure["line"]) == (
        "bad",
        "InputError",
        str(table),
        2,
    )
    assert list(made.table().index) == ["good"]
    with pytest.raises(jd.InputError, match="not identified yet"):
        made.identification("bad")


def test_fleets_refuse_what_they_cannot_do(tmp_path):
    with pytest.raises(jd.InputError, match="no subfolder"):
        jd.Fleet(tmp_path / "out", None, tmp_path)
    with pytest.raises(jd.InputError, match="is empty"):
        jd.Fleet(tmp_path / "out", None, {})
    with pytest.raises(jd.InputError, match="Dask client or an executor"):
        jd.Fleet(tmp_path / "out", None, {"m": "measurements/tian"}).run("tcp://somewhere")
    with pytest.raises(jd.InputError, match="there is no «n»"):
        jd.Fleet(tmp_path / "out", {"m": "configs/tian.toml"}, {"n": "measurements/tian"})


@forks
def test_fleets_refuse_a_pool_that_forks(tmp_path):
    with (
        ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("fork")) as forking,
        pytest.raises(jd.InputError, match="spawn"),
    ):
        jd.Fleet(tmp_path / "out", None, {"m": "measurements/tian"}).run(forking)


def test_many_machines_come_back_with_their_truths(tmp_path):
    truths = K_N[::4]
    made = fleet(tmp_path, {f"m{at:03d}": taps(k_n, at, 0.01, FEW) for at, k_n in enumerate(truths)})
    with pool() as executor:
        run = made.run(executor)
    assert (run.done, run.failures) == (50, ())
    table = made.table()
    holds = (table["k_n_low"] <= truths) & (truths <= table["k_n_high"])
    # 95 % intervals: fewer than 42 of 50 have a probability of 0.1 % (binomial).
    assert holds.sum() >= 42
    assert np.corrcoef(np.log(table["k_n"]), np.log(truths))[0, 1] > 0.9


def test_coverage_is_that_of_the_intervals(tmp_path):
    common = {
        "response": "table",
        "excitation": "table",
        "draws": 6,
        "noise": 0.01,
        "freeze": SETTINGS["freeze"],
    }
    with pool() as executor:
        rows = jd.coverage(tmp_path, "configs/tian.toml", NUTS, FEW, client=executor, **common)
        again = jd.coverage(tmp_path, "configs/tian.toml", NUTS, FEW, client=executor, **common)
    assert rows.equals(again) and rows["draw"].nunique() == 6
    assert ((rows["low"] <= rows["truth"]) & (rows["truth"] <= rows["high"]) | ~rows["holds"]).all()
    assert rows["holds"].mean() > 0.7


def test_the_blind_check_runs_on_an_executor(tmp_path, monkeypatch):
    target = Path(__file__).parents[2] / "target"
    built = [
        target / profile / "jointid-lab"
        for profile in ("debug", "release")
        if (target / profile / "jointid-lab").is_file()
    ]
    if not built:
        pytest.skip("jointid-lab is not built")
    newest = max(built, key=lambda file: file.stat().st_mtime)
    monkeypatch.setenv("PATH", f"{newest.parent}{os.pathsep}{os.environ['PATH']}")
    with pool() as executor:
        document = jd.blind_check(tmp_path, cases=2, seed=5, client=executor)
    # A look-alike has a second case with the measurement that the first verdict proposes.
    assert len(document["cases"]) >= 2 and document["complete"]


def test_the_blind_check_says_that_the_laboratory_is_missing(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    for variable in ("CARGO", "CARGO_MANIFEST_DIR"):
        monkeypatch.delenv(variable, raising=False)
    with pool() as executor, pytest.raises(jd.InputError, match="jointid-lab.*cargo install"):
        jd.blind_check(tmp_path, cases=2, client=executor)
