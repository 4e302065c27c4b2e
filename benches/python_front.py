#!/usr/bin/env python3
"""Measures the Python package: against the library it stands on, against other packages at the same work, and fleets on one and two workers.

    python3 -m venv target/peers && target/peers/bin/pip install '.[all]' pyuff==2.5.8 sdypy-EMA==0.31.0
    target/peers/bin/python benches/python_front.py [--rounds 20]

Both sides of a row run in turn in one run. Times are processor times unless a row says otherwise; a ratio is that of one round, the table shows the median.
"""

import argparse
import json
import multiprocessing
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import numpy as np  # noqa: E402

import jointid as jd  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[1]
CHANNEL = {"quantity": "receptance", "response": "table", "excitation": "table"}


def timed(work, clock=time.process_time):
    begun = clock()
    work()
    return clock() - begun


def in_turn(rounds, ours, theirs):
    """Times of both, each round in the other order."""
    pairs = []
    for number in range(rounds):
        if number % 2:
            second = theirs()
            pairs.append((ours(), second))
        else:
            first = ours()
            pairs.append((first, theirs()))
    return pairs


def row(what, pairs, aim):
    """Prints a row: what, medians of both sides, and the median of the ratios first over second."""
    ratio = statistics.median(a / b for a, b in pairs)
    first, second = (statistics.median(column) for column in zip(*pairs, strict=True))
    print(f"| {what} | {1e3 * first:.3g} ms | {1e3 * second:.3g} ms | {ratio:.3g} | {aim} |", flush=True)


def of_child(command):
    """Processor time of a command (s)."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def bench_binary():
    """The library side of the comparison of other programs, which times the same call in Rust."""
    command = ["cargo", "bench", "--bench", "side_by_side", "--no-run", "--message-format=json"]
    output = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True).stdout
    messages = [json.loads(line) for line in output.splitlines() if line.startswith("{")]
    return next(
        m["executable"] for m in messages if m.get("executable") and m["target"]["name"] == "side_by_side"
    )


def imports(rounds):
    command = [sys.executable, "-c", "import jointid"]
    numpy = [sys.executable, "-c", "import numpy"]
    wall = [timed(lambda: subprocess.run(command, check=True), time.perf_counter) for _ in range(rounds)]
    bare = [timed(lambda: subprocess.run(numpy, check=True), time.perf_counter) for _ in range(rounds)]
    print(
        f"import jointid: {statistics.median(wall):.3f} s of wall time, interpreter included (import numpy alone: {statistics.median(bare):.3f} s)"
    )


def responses(rounds, binary):
    found = jd.Study().choose_fit(["l1", "l3", "l5"]).identify(progress=False)
    lines = np.arange(6.0, 1006.0)

    def ours():
        return timed(lambda: [found.frf(lines, nut_m=0.6, **CHANNEL) for _ in range(200)]) / 200

    def rust():
        ran = subprocess.run(
            [binary, "identified-frf", "--repeats", "200"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        )
        return json.loads(ran.stdout)["seconds"] / 200

    row(
        "FRF of the identified bench, 1,000 lines: Python against the call in Rust",
        in_turn(rounds, ours, rust),
        "≤ 1.5",
    )


def identification(rounds):
    study = jd.Study().choose_fit(["l1", "l3", "l5"])
    command = [
        sys.executable,
        "-m",
        "jointid",
        "identify",
        "--positions",
        "l1,l3,l5",
        "--threads",
        "1",
        "--json",
    ]
    start = of_child([sys.executable, "-m", "jointid", "effects", "rotor-hold"])

    def python():
        return timed(lambda: study.identify(threads=1, progress=False))

    row(
        "identification of the bench: Python against the command, less its start",
        in_turn(rounds, python, lambda: of_child(command) - start),
        "≤ 1.03",
    )


def universal_files(rounds, folder):
    import pyuff

    lines = np.linspace(1.0, 1000.0, 6401)
    values = jd.Study().frf(lines, nut_m=[0.6, 1.2, 1.8], **CHANNEL)
    records = [{"record": f"r{at}", "frequency_hz": lines, "value": values[at % 3]} for at in range(60)]
    file = folder / "taps.uff"
    jd.MeasurementSet.from_arrays(frfs=records, **CHANNEL).to_uff(file)
    assert len(pyuff.UFF(str(file)).read_sets()) >= 60 and len(jd.read_uff(file).frfs) == 60
    pairs = in_turn(
        rounds,
        lambda: timed(lambda: pyuff.UFF(str(file)).read_sets()),
        lambda: timed(lambda: jd.read_uff(file)),
    )
    row(
        "universal file, 60 × 6,401 lines, binary: pyuff 2.5.8 against jd.read_uff, which also checks every line",
        pairs,
        "≥ 1",
    )


def modal(rounds):
    from sdypy import EMA

    lines = np.arange(5.0, 800.0, 0.5)
    nuts = {"p1": 0.6, "p2": 1.2, "p3": 1.8}
    values = jd.Study(overrides={"parameter.k_s.start": 2e4}).frf(lines, nut_m=list(nuts.values()), **CHANNEL)
    noise = np.random.default_rng(1).normal(size=(2, *values.shape)) * 0.003
    values = values * (1 + noise[0] + 1j * noise[1])
    taps = jd.MeasurementSet.from_arrays(lines, dict(zip(nuts, values, strict=True)), nut_m=nuts, **CHANNEL)

    def theirs():
        for response in values:
            model = EMA.Model(response[None, :], lines, lower=5, upper=lines[-1], pol_order_high=48)
            model.get_poles(show_progress=False)

    found = jd.peaks(taps)

    def ours():
        for name in nuts:
            found.stabilisation(name)

    pairs = in_turn(rounds, lambda: timed(theirs), lambda: timed(ours))
    row(
        "stabilisation diagrams of 3 × 1,590 lines to order 48: sdypy-EMA 0.31.0 against jd.peaks(…).stabilisation",
        pairs,
        "> 1",
    )
    pairs = in_turn(rounds, lambda: timed(theirs), lambda: timed(lambda: jd.peaks(taps)))
    row(
        "the same diagrams of sdypy-EMA against jd.peaks, which also chooses modes, refines and tracks them",
        pairs,
        "",
    )


def search(rounds):
    sys.path.insert(0, str(ROOT / "benches/peers"))
    import tasks

    study = jd.Study().choose_fit(["l1", "l3", "l5"])
    pairs = in_turn(
        rounds,
        lambda: timed(lambda: tasks.search("refined", 15, 200, 1)),
        lambda: timed(lambda: study.identify(threads=1, progress=False)),
    )
    row(
        "identification of the bench from modes: SciPy's differential evolution, 24,120 evaluations, against identify with intervals",
        pairs,
        "> 1",
    )


def fleets(folder, rounds):
    lines, nuts = np.linspace(8.0, 400.0, 60), {"p1": 0.6, "p2": 1.2, "p3": 1.8}
    values = jd.Study().frf(lines, nut_m=list(nuts.values()), **CHANNEL)
    generator = np.random.default_rng(1)
    sets = {}
    for at in range(200):
        noise = generator.normal(size=(2, *values.shape)) * 0.007
        measured = dict(zip(nuts, values * (1 + noise[0] + 1j * noise[1]), strict=True))
        relative_sd = {name: np.full(lines.size, 0.01) for name in nuts}
        sets[f"m{at:03d}"] = jd.MeasurementSet.from_arrays(
            lines, measured, relative_sd=relative_sd, nut_m=nuts, **CHANNEL
        )

    halves = [list(sets.values())[at::2] for at in range(2)]

    def seconds(workers, name):
        """Times of a fleet, of the same machines one after another in each worker, and of the fleet again."""
        made = jd.Fleet(folder / name, "configs/tian.toml", sets, tolerances=False)
        with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as executor:
            # Workers start before the clock does.
            list(executor.map(time.sleep, [0.5] * workers))
            run = made.run(executor)
            plain = timed(lambda: list(executor.map(identify_each, halves)), time.perf_counter)
        assert (run.done, run.failures) == (200, ())
        again = made.run(ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")))
        return run.seconds, plain, again.seconds

    one, two = zip(*((seconds(1, f"one-{at}"), seconds(2, f"two-{at}")) for at in range(rounds)), strict=True)
    row(
        "fleet of 200 machines, wall time: one worker against two",
        [(a[0], b[0]) for a, b in zip(one, two, strict=True)],
        "≥ 1.8",
    )
    row(
        "the same machines without a fleet, one after another in each worker",
        [(a[1], b[1]) for a, b in zip(one, two, strict=True)],
        "",
    )
    each, overhead = (
        statistics.median(of) / 200 for of in ([a for a, _, _ in two], [a - b for a, b, _ in two])
    )
    kept = statistics.median(again for _, _, again in one + two) / 200
    print(f"a machine on two workers: {1e3 * each:.1f} ms, of which {1e3 * overhead:.1f} ms overhead;")
    print(
        f"a machine that is there already: {1e3 * kept:.2f} ms; 1,000 machines {1000 * each:.0f} s, 100,000 machines {1e5 * each / 3600:.1f} h (extrapolated)"
    )


def identify_each(sets):
    for measured in sets:
        jd.Study("configs/tian.toml", measured).identify(tolerances=False, threads=1, progress=False)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=20)
    rounds = parser.parse_args().rounds
    imports(rounds)
    print("| work: first against second | first | second | first / second | aim |\n|---|---|---|---|---|")
    responses(min(rounds, 10), bench_binary())
    identification(rounds)
    with tempfile.TemporaryDirectory() as folder:
        universal_files(min(rounds, 10), pathlib.Path(folder))
        modal(min(rounds, 5))
        search(min(rounds, 5))
        fleets(pathlib.Path(folder), 3)


if __name__ == "__main__":
    main()
