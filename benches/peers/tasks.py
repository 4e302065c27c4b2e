"""Tasks of the peers: side_by_side.py runs each in a process of its own. A task repeats its work and prints one line of JSON.

python benches/peers/tasks.py NAME < arguments.json
"""

import json
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from bench_model import Bench, FrfObjective, Lines, ModeObjective

CHUNKS = (1, 2, 4, 8, 16, 32, 120)


def timed(work, each=1, least=0.3):
    """Measures mean processor and wall time (s) of one evaluation, `each` of them per repetition, over at least `least` seconds."""
    work()
    repeats, begin, given = 0, time.perf_counter(), time.thread_time()
    while time.perf_counter() - begin < least:
        work()
        repeats += 1
    return {
        "seconds": (time.thread_time() - given) / repeats / each,
        "wall": (time.perf_counter() - begin) / repeats / each,
    }


def objective(form):
    """Builds the objective on modes in one of its forms: grid, refined, fine-grid; with the fastest number of members per pass."""
    bench = Bench()
    lines = ModeObjective.fine_grid(bench) if form == "fine-grid" else ModeObjective.grid(bench)
    made = [
        ModeObjective(bench, lines, form == "refined", chunk)
        for chunk in (CHUNKS[:3] if form == "fine-grid" else CHUNKS)
    ]
    sample = np.random.default_rng(0).random((len(bench.free_for_modes), 120))
    return min(made, key=lambda o: timed(lambda: o.at(sample), least=0.02)["seconds"])


def receptances(places, parameters):
    bench = Bench()
    lines = Lines(bench, np.arange(1.0, 2001.0)[None, :], bench.nuts[:, None])
    values = lines.receptance(bench.parameters(parameters, np.array(places).T)).ravel()
    return {"receptances": np.stack([values.real, values.imag], axis=-1).tolist()}


def modes(places, form, peaks=False):
    """Evaluates the objective for all members at once, as a vectorised search does."""
    made, places = objective(form), np.array(places).T
    out = {
        "costs": made.at(places).tolist(),
        "lines": len(made.frequencies),
        **timed(lambda: made.at(places), places.shape[1]),
    }
    if peaks:
        found = made.peaks(places)[0]
        out["peaks"] = [[[f for f in row if np.isfinite(f)] for row in member] for member in found]
    return out


def search(form, popsize, generations, seed, threads=1):
    """Runs SciPy's differential evolution in the unit cube, with the members of a generation shared among threads.

    SciPy's `nfev` counts vectorised calls, so evaluations are counted here.
    """
    from scipy.optimize import differential_evolution

    made = objective(form)
    pool = ThreadPoolExecutor(threads)
    count, trace = 0, []

    def cost(places):
        nonlocal count
        count += places.shape[1]
        if threads == 1:
            return made.at(places)
        return np.concatenate(list(pool.map(made.at, np.array_split(places, threads, axis=1))))

    begin, wall = time.thread_time(), time.perf_counter()

    def callback(intermediate_result):
        trace.append(
            (time.thread_time() - begin, float(intermediate_result.fun), intermediate_result.x.tolist())
        )

    bounds = [(0.0, 1.0)] * len(made.bench.free_for_modes)
    found = differential_evolution(
        cost,
        bounds,
        popsize=popsize,
        maxiter=generations,
        tol=0,
        polish=False,
        vectorized=True,
        updating="deferred",
        rng=seed,
        callback=callback,
    )
    times = {"seconds": time.thread_time() - begin, "wall": time.perf_counter() - wall}
    return {
        **times,
        "evaluations": count,
        "cost": float(found.fun),
        "place": found.x.tolist(),
        "trace": trace,
    }


def frfs(places):
    made = FrfObjective(Bench())
    places = np.array(places)
    work = lambda: [made.at(place) for place in places]
    return {"costs": [float(c) for c in work()], **timed(work, len(places))}


def frf_cost(values):
    return {"cost": float(FrfObjective(Bench(), noise=True).of(values))}


def frf_search(target, generations, seed):
    """Runs SciPy's differential evolution with default settings on whole FRFs, until χ² is at most `target` or all generations have run."""
    from scipy.optimize import differential_evolution

    made = FrfObjective(Bench(), noise=True)
    bounds = [(0.0, 1.0)] * len(made.names)
    reached = lambda intermediate_result: intermediate_result.fun <= target
    begin = time.thread_time()
    found = differential_evolution(
        made.at, bounds, maxiter=generations, tol=0, polish=False, rng=seed, callback=reached
    )
    return {"seconds": time.thread_time() - begin, "evaluations": found.nfev, "cost": float(found.fun)}


def substructures(machine):
    """Returns receptances of the free substructures (line, i, i), the signed Boolean B, joint receptances (line, row), the table's index."""
    bench = Bench()
    omega = 2 * np.pi * np.arange(6.0, 1006.0)
    nut, p = bench.nuts[1], bench.start
    blocks, rows, joints = [], [], []

    def rod(kind, length):
        stiffness, slowness = kind
        phase = omega * slowness * length
        direct, cross = (
            -1 / (stiffness * omega * slowness * np.tan(phase)),
            -1 / (stiffness * omega * slowness * np.sin(phase)),
        )
        blocks.append(np.moveaxis(np.array([[direct, cross], [cross, direct]]), 2, 0))
        return [sum(b.shape[1] for b in blocks) - 2 + i for i in (0, 1)]

    def inertia(value):
        blocks.append((-1 / (value * omega * omega))[:, None, None])
        return sum(b.shape[1] for b in blocks) - 1

    def couple(on, receptance=0.0):
        rows.append(on)
        joints.append(receptance * np.ones_like(omega))

    spring = lambda k, c: 1 / (k + 1j * omega * c)
    a, b = rod(bench.axial, nut), rod(bench.axial, bench.length - nut)
    couple({a[1]: 1, b[0]: -1})
    couple({a[0]: 1}, spring(p["k_al"], p["c_al"]))
    couple({b[1]: 1}, spring(p["k_ar"], p["c_ar"]))
    table = a[1]
    if machine == "bench":
        s, t = rod(bench.torsional, nut), rod(bench.torsional, bench.length - nut)
        rotor, table = inertia(bench.rotor), inertia(bench.table)
        couple({s[1]: 1, t[0]: -1})
        # An inertia at a rod's end is coupled to the ground through its receptance.
        for at, value in ((a[1], bench.screw), (s[1], bench.nut), (s[0], bench.left)):
            couple({at: 1}, -1 / (value * omega * omega))
        couple({rotor: 1}, spring(p["k_s"], p["c_s"]))
        couple({rotor: 1, s[0]: -1}, spring(p["k_m"], p["c_m"]))
        couple({table: 1, a[1]: -1, s[1]: -bench.lead}, spring(p["k_n"], p["c_n"]))
    size = sum(b.shape[1] for b in blocks)
    y = np.zeros((omega.size, size, size), dtype=complex)
    at = 0
    for block in blocks:
        y[:, at : at + block.shape[1], at : at + block.shape[1]] = block
        at += block.shape[1]
    signed = np.zeros((len(rows), size))
    for row, on in zip(signed, rows):
        for i, value in on.items():
            row[i] = value
    return y, signed, np.array(joints, dtype=complex).T, table


def coupling(machine, form):
    """Computes LM-FBS, batched over lines: with `pinv` as in pyFBS' notebooks, with `solve`, or `one` entry alone with `solve`."""
    y, b, joints, table = substructures(machine)
    diagonal = joints[:, :, None] * np.eye(joints.shape[1])

    def work():
        interface = b @ y @ b.T + diagonal
        match form:
            case "pinv":
                return (y - y @ b.T @ np.linalg.pinv(interface) @ b @ y)[:, table, table]
            case "solve":
                by = b @ y
                return (y - np.swapaxes(by, 1, 2) @ np.linalg.solve(interface, by))[:, table, table]
            case "one":
                row = (b @ y[:, :, table].T).T
                return y[:, table, table] - np.einsum(
                    "li,li->l", row, np.linalg.solve(interface, row[:, :, None])[:, :, 0]
                )

    values = work()
    size = {"interface": joints.shape[1], "coordinates": y.shape[1]}
    return {
        "receptances": np.stack([values.real, values.imag], axis=-1).tolist(),
        **size,
        **timed(work, len(y)),
    }


def lumped(mass, damping, stiffness, table, form):
    """Computes the table's receptance from M, C and K: batched `solve` of the dynamic stiffness, or `modes` of the state-space form."""
    m, c, k = np.array(mass), np.array(damping), np.array(stiffness)
    omega = 2 * np.pi * np.arange(6.0, 1006.0)
    force = np.zeros((len(m), 1))
    force[table] = 1
    inertia, i_omega = -(omega**2)[:, None, None] * m, 1j * omega[:, None, None]

    def solve():
        return np.linalg.solve(i_omega * c + (inertia + k), force.astype(complex))[:, table, 0]

    def modes():
        # M is diagonal. ẋ = A·x + b·f, with x the displacements and velocities; H = Σ (left·b)·(right at the table)/(iω − λ).
        inverse = 1 / np.diag(m)[:, None]
        n = len(m)
        a = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse * k, -inverse * c]])
        poles, shapes = np.linalg.eig(a)
        share = np.linalg.solve(shapes, np.concatenate([np.zeros(n), inverse[:, 0] * force[:, 0]]))
        return (shapes[table] * share / (1j * omega[:, None] - poles)).sum(axis=1)

    work = solve if form == "solve" else modes
    values = work()
    return {
        "receptances": np.stack([values.real, values.imag], axis=-1).tolist(),
        "coordinates": len(m),
        **timed(work, omega.size),
    }


def universal(file):
    import pyuff

    read = lambda: pyuff.UFF(file).read_sets()
    total = sum(np.sum(s["data"]) for s in read())
    return {"sum": [total.real, total.imag], "records": len(read()), **timed(read)}


if __name__ == "__main__":
    print(json.dumps(globals()[sys.argv[1]](**json.loads(sys.stdin.read()))))
