#!/usr/bin/env python3
"""Compares the speed of jointid with that of other programs at the same work, measured in turn: ours, theirs, ours, theirs, …

Requirements: numpy==2.4.6 scipy==1.17.1 pyuff==2.5.8, Python 3.11 or later. Comparisons with a missing package are skipped with a note.

    python3 -m venv target/peers && target/peers/bin/pip install numpy scipy pyuff
    target/peers/bin/python benches/side_by_side.py [--rounds 5] [--only WORD …] [--instructions] [--out FILE]

Each ratio is the time of the other program over ours in the same round: above 1 jointid is faster. The table shows the least, median and largest
ratio of the rounds. Every other program has its best form: closed form, precomputed ω-terms, one division, the fastest number of members per
pass (found by trial), and an allocator that keeps its memory (the MALLOC_ settings below, several times faster than the default).
Ours runs on one thread unless the row says otherwise. Theirs runs with BLAS pinned to one thread, and again unpinned where BLAS does the work.
The time of one thread is its processor time (ours: on Linux), which other load on the machine disturbs little. With several threads it is the
wall time on both sides. The script first checks that both sides compute the same, and ends where they do not.
"""

import argparse
import importlib.util
import json
import os
import pathlib
import random
import re
import statistics
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

ROOT = pathlib.Path(__file__).resolve().parents[1]
PINNED = {name: "1" for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")}
KEEPS_MEMORY = {
    "MALLOC_MMAP_THRESHOLD_": "1000000000",
    "MALLOC_TRIM_THRESHOLD_": "1000000000",
    "MALLOC_TOP_PAD_": "100000000",
}
LINES, POSITIONS = 1000, 3


def parsed(process):
    if process.returncode:
        raise SystemExit(f"{' '.join(map(str, process.args))}\n{process.stderr}")
    return json.loads(process.stdout)


def built():
    """Builds the bench binary of the release profile and returns its path."""
    command = ["cargo", "bench", "--bench", "side_by_side", "--no-run", "--message-format=json"]
    output = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True).stdout
    messages = [json.loads(line) for line in output.splitlines() if line.startswith("{")]
    return next(
        m["executable"] for m in messages if m.get("executable") and m["target"]["name"] == "side_by_side"
    )


class Sides:
    """Runs the tasks of both sides, each in a process of its own."""

    def __init__(self, binary, folder):
        self.binary, self.folder = binary, pathlib.Path(folder)

    def ours(self, task, *arguments, repeats=1, threads=1):
        """Runs one task of benches/side_by_side.rs; `each` is the time of one evaluation."""
        command = [
            self.binary,
            task,
            *map(str, arguments),
            "--repeats",
            str(repeats),
            "--threads",
            str(threads),
        ]
        result = parsed(subprocess.run(command, cwd=ROOT, capture_output=True, text=True))
        if result.get("evaluations"):
            result["each"], result["wall_each"] = (
                result[clock] / result["evaluations"] for clock in ("seconds", "wall")
            )
        return result

    def theirs(self, task, pinned=True, **arguments):
        """Runs one task of benches/peers/tasks.py."""
        environment = (
            {k: v for k, v in os.environ.items() if k not in PINNED}
            | KEEPS_MEMORY
            | (PINNED if pinned else {})
        )
        command = [sys.executable, "-B", ROOT / "benches/peers/tasks.py", task]
        return parsed(
            subprocess.run(
                command, input=json.dumps(arguments), env=environment, capture_output=True, text=True
            )
        )

    def places(self, count, dimension, name="places.json"):
        """Returns random points of the unit cube, and a file with them for our side."""
        draw = random.Random(1)
        places = [[draw.random() for _ in range(dimension)] for _ in range(count)]
        return places, self.written(places, name)

    def written(self, places, name):
        file = self.folder / name
        file.write_text(json.dumps(places))
        return file


class Table:
    """Table of ratios in Markdown."""

    def __init__(self):
        self.lines = [
            "| work | compared with | ours | theirs | theirs / ours: least, median, largest | aim |",
            "|---|---|---|---|---|---|",
        ]
        self.notes = []

    def ratios(self, work, peer, ours, theirs, aim=""):
        """Adds a row from the times (s) of both sides, round by round."""
        ratio = sorted(b / a for a, b in zip(ours, theirs, strict=True))
        ratios = f"{ratio[0]:.2f}, **{statistics.median(ratio):.2f}**, {ratio[-1]:.2f}"
        times = f"{duration(statistics.median(ours))} | {duration(statistics.median(theirs))}"
        self.lines.append(f"| {work} | {peer} | {times} | {ratios} | {aim} |")
        print(self.lines[-1], flush=True)

    def note(self, text):
        self.notes.append(text)
        print(text, flush=True)


def duration(seconds):
    for limit, unit, scale in ((1e-6, "ns", 1e9), (1e-3, "µs", 1e6), (1, "ms", 1e3)):
        if seconds < limit:
            return f"{seconds * scale:.3g} {unit}"
    return f"{seconds:.3g} s"


def in_turn(rounds, *works):
    """Runs all works in turn, round by round; returns one list of results per work."""
    results = [[work(number) for work in works] for number in range(rounds)]
    return [list(column) for column in zip(*results)]


def column(results, key):
    return [r[key] for r in results]


def deviation(a, b):
    """Returns the largest relative deviation of two lists of numbers or (real, imaginary) pairs."""
    number = lambda x: complex(*x) if isinstance(x, list) else x
    return max(abs(number(x) / number(y) - 1) for x, y in zip(a, b, strict=True))


def same(table, what, found, limit):
    """Ends the script if two programs do not compute the same."""
    table.note(f"{what}: largest relative deviation {found:.1e} (limit {limit:.0e})")
    if not found <= limit:
        raise SystemExit("the two sides do not compute the same; a ratio of their times has no meaning")


def modes(sides, table, rounds):
    """Compares the objective on modes, and searches of equal evaluations, on the usual grid and at equal accuracy of the peaks."""
    places, file = sides.places(10, 10)
    ours = sides.ours("receptances", file)
    theirs = sides.theirs("receptances", places=places, parameters=ours["parameters"])
    same(
        table,
        "receptances of the bench, 10 machines × 3 positions × 2,000 lines",
        deviation(theirs["receptances"], ours["receptances"]),
        1e-9,
    )
    places, file = sides.places(240, 8)
    exact = sides.ours("modes", file, "--peaks")
    forms = {
        "grid": "grid of 1 Hz",
        "refined": "grid of 1 Hz, then refined",
        "fine-grid": "grid of relative 2e-4",
    }
    for form, words in forms.items():
        found = sides.theirs("modes", places=places, form=form, peaks=True)
        missed, errors = peak_errors(exact["peaks"], found["peaks"])
        within = sum(e <= 1e-4 for e in errors) / len(errors)
        costs = sum(abs(a / b - 1) < 1e-3 for a, b in zip(found["costs"], exact["costs"])) / len(places)
        table.note(
            f"NumPy, {words} ({found['lines']} lines): median error of the peak frequencies {statistics.median(errors):.1e}, {100 * within:.1f} % of "
            f"them within 1e-4, {missed} of {missed + len(errors)} missed; {100 * costs:.0f} % of the costs within 0.1 %"
        )
    repeats = max(1, round(0.3 / exact["wall"]))
    runs = in_turn(
        rounds,
        lambda _: sides.ours("modes", file, repeats=repeats),
        *(lambda _, f=f: sides.theirs("modes", places=places, form=f) for f in forms),
    )
    for (form, words), theirs in zip(forms.items(), runs[1:]):
        table.ratios(
            "objective on modes, 3 positions × 4 orders",
            f"NumPy, {words}",
            column(runs[0], "each"),
            column(theirs, "seconds"),
        )
    if missing("scipy", table):
        return
    generations, popsize = 200, 15
    target = 1.01 * sides.ours("identify")["cost"]

    def searches(form, our_threads, *their_threads):
        """Runs ours and theirs in turn, theirs once per number of threads; returns the number of evaluations and the runs."""
        # A run of the fine grid takes minutes; fewer generations give the same time per evaluation.
        count = 10 if form == "fine-grid" else generations
        runs = in_turn(
            rounds,
            lambda seed: sides.ours(
                "search",
                "--population",
                popsize * 8,
                "--generations",
                count,
                "--seed",
                seed + 1,
                threads=our_threads,
            ),
            *(
                lambda seed, n=n: sides.theirs(
                    "search", form=form, popsize=popsize, generations=count, seed=seed + 1, threads=n
                )
                for n in their_threads
            ),
        )
        evaluations = {r["evaluations"] for run in runs for r in run}
        if len(evaluations) != 1:
            raise SystemExit(f"the searches differ in their numbers of evaluations: {evaluations}")
        return f"search of {evaluations.pop():,} evaluations", runs

    for form, words in forms.items():
        work, (ours, theirs) = searches(form, 1, 1)
        table.ratios(work, f"SciPy, {words}", column(ours, "seconds"), column(theirs, "seconds"))
        if form != "fine-grid":
            reached(sides, table, words, target, ours, theirs)
    for form, aim in (("grid", "10"), ("fine-grid", "100")):
        work, (ours, one, two) = searches(form, 2, 1, 2)
        table.ratios(
            f"{work}, on two threads", f"SciPy, {forms[form]}", column(ours, "wall"), column(one, "wall"), aim
        )
        table.ratios(
            "the same",
            f"SciPy, {forms[form]}, members shared by two threads",
            column(ours, "wall"),
            column(two, "wall"),
        )


def peak_errors(exact, found):
    """Counts peaks without a partner within 2 %, and returns the relative errors of the others; a prominence below 1.01 does not count."""
    missed, errors = 0, []
    for reference, rows in zip(exact, found, strict=True):
        for peaks, row in zip(reference, rows, strict=True):
            for frequency, _, prominence in peaks:
                nearest = min((abs(f / frequency - 1) for f in row), default=1)
                if prominence >= 1.01 and nearest > 0.02:
                    missed += 1
                elif prominence >= 1.01:
                    errors.append(nearest)
    return missed, errors


def reached(sides, table, words, target, ours, theirs):
    """Compares the times at which the searches reach a target cost; the exact objective evaluates the points of SciPy's search."""
    first = lambda trace: next((time for time, cost in trace if cost <= target), None)
    pairs, final = [], []
    for a, b in zip(ours, theirs, strict=True):
        exact = sides.ours("modes", sides.written([x for _, _, x in b["trace"]], "trace.json"))["costs"]
        final.append(exact[-1])
        pairs.append(
            (first(a["trace"]), first([(time, cost) for (time, _, _), cost in zip(b["trace"], exact)]))
        )
    both = [(a, b) for a, b in pairs if a and b]
    count = lambda side: sum(p[side] is not None for p in pairs)
    table.note(
        f"cost {target:.3f} (1 % above the best known) was reached by {count(0)} of {len(pairs)} of our searches and {count(1)} of SciPy's "
        f"({words}); median final costs {statistics.median(column(ours, 'cost')):.3f} and {statistics.median(final):.3f}"
    )
    if both:
        table.ratios(
            "the same: time to that cost, where both reach it", f"SciPy, {words}", *map(list, zip(*both))
        )


def frfs(sides, table, rounds):
    """Compares χ² of whole FRFs, and identifications from them."""
    places, file = sides.places(20, 10)
    exact = sides.ours("frfs", file)
    same(
        table,
        "χ² of whole FRFs, 20 machines",
        deviation(sides.theirs("frfs", places=places)["costs"], exact["costs"]),
        1e-9,
    )
    repeats = max(1, round(0.3 / exact["wall"]))
    ours, theirs = in_turn(
        rounds,
        lambda _: sides.ours("frfs", file, repeats=repeats),
        lambda _: sides.theirs("frfs", places=places),
    )
    table.ratios(
        f"objective on whole FRFs, {POSITIONS} × {LINES} lines",
        "NumPy, closed form",
        column(ours, "each"),
        column(theirs, "seconds"),
        "12",
    )
    if missing("scipy", table):
        return
    cost = lambda found: sides.theirs("frf_cost", values=found["values"])["cost"]
    target = 1.01 * cost(sides.ours("identify-frfs"))
    ours, profiled, theirs = in_turn(
        rounds,
        lambda seed: sides.ours("identify-frfs", "--seed", seed + 1),
        lambda seed: sides.ours("identify-frfs", "--seed", seed + 1, "--profile"),
        lambda seed: sides.theirs("frf_search", target=target, generations=1000, seed=seed + 1),
    )
    if not all(cost(found) <= target for found in ours + profiled):
        raise SystemExit("our identifications from whole FRFs do not all reach the same χ²")
    reaching = [
        (a["seconds"], p["seconds"], b["seconds"])
        for a, p, b in zip(ours, profiled, theirs)
        if b["cost"] <= target
    ]
    evaluations = statistics.median(column(theirs, "evaluations"))
    table.note(
        f"SciPy reached 1.01 times our χ² of {target / 1.01:.1f} in {len(reaching)} of {rounds} searches, with a median of {evaluations:,.0f} evaluations"
    )
    if reaching:
        alone, with_intervals, others = map(list, zip(*reaching))
        table.ratios(
            "identification from whole FRFs",
            "SciPy, differential evolution to the same χ²",
            alone,
            others,
            "12",
        )
        table.ratios(
            "the same with intervals by profile likelihood",
            "SciPy, which computes none",
            with_intervals,
            others,
        )


def coupling(sides, table, rounds):
    """Compares substructure coupling with LM-FBS as in pyFBS' notebooks. Ours also computes the rods at each line; theirs are precomputed."""
    forms = {"pinv": "LM-FBS with pinv", "solve": "LM-FBS with solve", "one": "LM-FBS with solve, one entry"}
    for machine in ("screw", "bench"):
        exact = sides.ours("coupling", machine)["receptances"]
        works = [
            lambda _: sides.ours("coupling", machine, repeats=5000),
            lambda _: sides.ours("coupling", machine, "--all", repeats=500),
        ]
        works += [
            lambda _, f=f, p=p: sides.theirs("coupling", p, machine=machine, form=f)
            for f in forms
            for p in (True, False)
        ]
        runs = in_turn(rounds, *works)
        found = runs[2][0]
        for (form, words), at in zip(forms.items(), (2, 4, 6)):
            same(
                table,
                f"coupling of the {machine}, {words}",
                deviation(runs[at][0]["receptances"], exact),
                1e-6 if form == "pinv" else 1e-9,
            )
        size = f"{found['coordinates']} coordinates, {found['interface']} conditions"
        one, one_wall, every = column(runs[0], "each"), column(runs[0], "wall_each"), column(runs[1], "each")
        for (form, words), at in zip(forms.items(), (2, 4, 6)):
            aim = "20" if form == "pinv" else ""
            pinned, free = column(runs[at], "seconds"), column(runs[at + 1], "wall")
            table.ratios(f"line of coupling, {size}: one receptance", words, one, pinned, aim)
            table.ratios("the same", f"{words}, BLAS unpinned", one_wall, free)
            if form != "one":
                table.ratios("the same: all receptances, by receptance coupling", words, every, pinned)


def lumped(sides, table, rounds):
    """Compares the lumped model with a batched solve of its dynamic stiffness, and with its state-space modes."""
    for lumps in (1, 5, 10, 20):
        exact = sides.ours("lumped", lumps, "--matrices")
        ask = exact["matrices"]
        works = [lambda _: sides.ours("lumped", lumps, repeats=5000)]
        works += [
            lambda _, f=f, p=p: sides.theirs("lumped", p, **ask, form=f)
            for f in ("solve", "modes")
            for p in (True, False)
        ]
        runs = in_turn(rounds, *works)
        for at, form in ((1, "solve"), (3, "modes")):
            same(
                table,
                f"lumped model, {lumps} springs per rod, {form}",
                deviation(runs[at][0]["receptances"], exact["receptances"]),
                1e-8,
            )
        ours, work = (
            column(runs[0], "each"),
            f"line of the lumped model, {runs[1][0]['coordinates']} coordinates",
        )
        table.ratios(work, "numpy.linalg.solve, batched", ours, column(runs[1], "seconds"), "20")
        wall = column(runs[0], "wall_each")
        table.ratios("the same", "numpy.linalg.solve, batched, BLAS unpinned", wall, column(runs[2], "wall"))
        table.ratios("the same", "numpy.linalg.eig once, then a modal sum", ours, column(runs[3], "seconds"))
        table.ratios(
            "the same",
            "numpy.linalg.eig once, then a modal sum, BLAS unpinned",
            wall,
            column(runs[4], "wall"),
        )


def universal(sides, table, rounds):
    """Compares the reading of universal files of 60 FRFs of 6,401 lines."""
    if missing("pyuff", table):
        return
    for words, flags in (("text", []), ("binary", ["--binary"])):
        file = sides.folder / f"{words}.uff"
        size = sides.ours("write-universal", file, *flags)["bytes"]
        ours, theirs = in_turn(
            rounds,
            lambda _: sides.ours("read-universal", file, repeats=10),
            lambda _: sides.theirs("universal", file=str(file)),
        )
        same(
            table,
            f"universal file, {words}, sum of the values",
            deviation([theirs[0]["sum"]], [ours[0]["sum"]]),
            1e-9,
        )
        table.ratios(
            f"universal file, {words}, {size / 1e6:.1f} MB",
            "pyuff",
            column(ours, "each"),
            column(theirs, "seconds"),
            "4",
        )


def threads(sides, table, rounds):
    """Compares the default identification on one thread and on two."""
    two, one = in_turn(
        rounds, lambda _: sides.ours("identify", threads=2), lambda _: sides.ours("identify", threads=1)
    )
    if {r["cost"] for r in one} != {r["cost"] for r in two}:
        raise SystemExit("the result depends on the number of threads")
    work = f"identify, default plan, {one[0]['evaluations']:,} evaluations, on two threads"
    table.ratios(work, "ours on one thread", column(two, "wall"), column(one, "wall"), "1.8")
    # Upper limit set by the machine: two independent runs at once.
    with ThreadPoolExecutor(2) as pool:
        pair = lambda: list(pool.map(lambda _: sides.ours("identify", threads=1), range(2)))
        both, alone = in_turn(
            rounds,
            lambda _: max(column(pair(), "wall")) / 2,
            lambda _: sides.ours("identify", threads=1)["wall"],
        )
    table.ratios(
        "half the time of two independent runs at once, one thread each: limit of the machine",
        "one run alone",
        both,
        alone,
    )


COMPARISONS = {
    "modes": modes,
    "frfs": frfs,
    "coupling": coupling,
    "lumped": lumped,
    "universal": universal,
    "threads": threads,
}


def instructions(sides):
    """Prints the instructions of one evaluation: the difference of callgrind's counts for two numbers of repetitions, over their difference."""
    modes_file, frfs_file = sides.places(20, 8, "modes.json")[1], sides.places(5, 10, "frfs.json")[1]
    file = sides.folder / "text.uff"
    sides.ours("write-universal", file)
    tasks = {
        "objective on modes, 3 positions × 4 orders": (["modes", modes_file], 20),
        "objective on whole FRFs, 3 × 1000 lines": (["frfs", frfs_file], 5),
        "line of coupling, bench": (["coupling", "bench"], LINES),
        "line of the lumped model, 20 springs per rod": (["lumped", 20], LINES),
        "universal file, text, 60 × 6,401 lines": (["read-universal", file], 1),
    }
    print("| work | instructions per evaluation |\n|---|---|")
    for words, (task, evaluations) in tasks.items():
        counts = []
        for repeats in (1, 3):
            command = [
                "valgrind",
                "--tool=callgrind",
                "--callgrind-out-file=/dev/null",
                sides.binary,
                *map(str, task),
                "--repeats",
                str(repeats),
            ]
            report = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stderr
            counts.append(int(re.search(r"Collected : (\d+)", report).group(1)))
        print(f"| {words} | {(counts[1] - counts[0]) / (2 * evaluations):,.0f} |", flush=True)


def missing(package, table):
    absent = importlib.util.find_spec(package) is None
    if absent:
        table.note(f"skipped: package {package} is not installed")
    return absent


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=5, help="rounds in which the sides take turns")
    parser.add_argument(
        "--only", nargs="+", choices=COMPARISONS, default=list(COMPARISONS), help="comparisons to run"
    )
    parser.add_argument(
        "--instructions", action="store_true", help="count our instructions with valgrind instead"
    )
    parser.add_argument("--binary", help="existing bench binary, instead of a new build")
    parser.add_argument("--out", type=pathlib.Path, help="Markdown file for table and notes")
    given = parser.parse_args()
    table = Table()
    with tempfile.TemporaryDirectory() as folder:
        sides = Sides(str(pathlib.Path(given.binary).resolve()) if given.binary else built(), folder)
        if given.instructions:
            return instructions(sides)
        for name in given.only:
            if name in ("universal", "threads") or not missing("numpy", table):
                COMPARISONS[name](sides, table, given.rounds)
    text = "\n".join([*table.lines, "", *(f"- {note}" for note in table.notes)])
    print(f"\n{text}")
    if given.out:
        given.out.write_text(text + "\n")


if __name__ == "__main__":
    main()
