"""The published ball-screw bench (configs/tian.toml) in its fastest NumPy form: closed form, precomputed ω-terms.

Substructures and joints as in Tian et al., Eq. 1-24, corrected (cot for cos, h_J = 1/(k + iωc)). Elimination from both ends of the screw inwards
yields one rational expression for the driving-point receptance of the table. As numerator over denominator it needs a single division,
whatever the number of joints. Arrays are (member, position, line); one pass handles as many members as fit the cache.
"""

import csv
import pathlib
import tomllib

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
MISSING = 0.3  # relative frequency error of a mode without a partner
FREQUENCY_MODEL_ERROR, AMPLITUDE_SD = 0.01, 0.13
ZOOM = 9  # points between the neighbours of a maximum of the grid


class Bench:
    """Machine and measurements of configs/tian.toml and measurements/tian."""

    def __init__(self):
        machine = tomllib.loads((ROOT / "configs/tian.toml").read_text())
        shaft, points = machine["shaft"][0], {p["name"]: p for p in machine["point"]}
        self.length, diameter, density = shaft["length_m"], shaft["diameter_m"], shaft["density_kg_m3"]
        area = np.pi * diameter**2 / 4
        self.axial = shaft["youngs_modulus_pa"] * area, np.sqrt(density / shaft["youngs_modulus_pa"])
        self.torsional = (
            shaft["shear_modulus_pa"] * area * diameter**2 / 8,
            np.sqrt(density / shaft["shear_modulus_pa"]),
        )
        self.table, self.screw = points["table"]["mass_kg"], points["screw"]["mass_kg"]
        self.rotor, self.left, self.nut = (
            points[n]["inertia_kg_m2"] for n in ("rotor", "left-angle", "screw-angle")
        )
        self.lead = next(j for j in machine["joint"] if j["name"] == "nut")["screw"]["lead_m"] / (2 * np.pi)
        described = dict(sorted(machine["parameter"].items()))  # in the order of jointid
        self.start = {name: p["start"] for name, p in described.items()}
        self.range = {name: (p["lower"], p["upper"]) for name, p in described.items()}
        self.free_for_modes = [name for name, p in described.items() if p.get("fit") != "frf"]
        manifest = tomllib.loads((ROOT / "measurements/tian/manifest.toml").read_text())
        self.resolution = manifest["frequency_resolution_hz"]
        self.least_prominence = manifest["least_prominence"]  # least prominence of a visible peak
        nuts = {p["name"]: p["nut_m"] for p in manifest["position"]}
        self.fitted = manifest["split"]["fit"]
        self.nuts = np.array([nuts[name] for name in self.fitted])
        rows = [
            r
            for r in csv.DictReader((ROOT / "measurements/tian/modes.csv").open())
            if r["position"] in self.fitted
        ]
        column = lambda key: np.array(
            [[float(r[key]) for r in rows if r["position"] == name] for name in self.fitted]
        )
        self.measured_hz, self.measured_amplitude = column("frequency_hz"), column("amplitude")

    def parameters(self, names, places):
        """Returns arrays (member, 1, 1) by name for unit-cube coordinates (coordinate, member); parameters without a name keep their start values."""
        values = dict(self.start)
        for name, unit in zip(names, np.asarray(places)):
            low, high = self.range[name]
            values[name] = (low * np.exp(unit * np.log(high / low)))[:, None, None]
        return values


class Lines:
    """ω-terms of the closed form at frequencies (1 or position, line) and nut positions (position, 1)."""

    def __init__(self, bench, frequencies_hz, nuts_m):
        omega = 2 * np.pi * frequencies_hz
        self.bench, self.omega, self.i_omega = bench, omega, 1j * omega
        square = omega * omega

        def rod(kind, length):
            """Returns the direct entry and the squared cross entry of the dynamic stiffness of a free-free rod."""
            stiffness, slowness = kind
            phase = omega * slowness * length
            sine = np.sin(phase)
            scale = stiffness * omega * slowness / sine
            return scale * np.cos(phase), scale * scale

        self.left, self.left_cross = rod(bench.axial, nuts_m)
        self.right, self.right_cross = rod(bench.axial, bench.length - nuts_m)
        self.middle = self.left + self.right - square * bench.screw
        turn, self.turn_cross = rod(bench.torsional, nuts_m)
        far, far_cross = rod(bench.torsional, bench.length - nuts_m)
        self.turn_end = turn - square * bench.left
        self.turn_middle = turn + far - far_cross / far - square * bench.nut
        self.rotor = -square * bench.rotor
        self.table = -square * bench.table

    def fraction(self, p):
        """Returns numerator and denominator of the table's receptance."""
        i_omega = self.i_omega
        left = (self.left + p["k_al"]) + i_omega * p["c_al"]
        right = (self.right + p["k_ar"]) + i_omega * p["c_ar"]
        # Axial dynamic stiffness at the nut: D_ax = ax / ends.
        ends = left * right
        ax = self.middle * ends - self.left_cross * right - self.right_cross * left
        # Spring and damper of the rotor to the ground. Torsional dynamic stiffness at the nut: D_t = turn / end.
        rotor = (self.rotor + p["k_s"]) + i_omega * p["c_s"]
        both = rotor + (p["k_m"] + i_omega * p["c_m"])
        end = (self.turn_end + rotor) * both - rotor * rotor
        turn = self.turn_middle * end - self.turn_cross * both
        nut = p["k_n"] + i_omega * p["c_n"]
        product = ax * turn
        above = product + nut * (turn * ends + self.bench.lead**2 * (ax * end))
        return above, nut * product + self.table * above

    def receptance(self, p):
        above, below = self.fraction(p)
        return above / below

    def mobility_square(self, p):
        """Returns |iω·H|² without a complex division."""
        above, below = self.fraction(p)
        return self.omega**2 * (above.real**2 + above.imag**2) / (below.real**2 + below.imag**2)


class ModeObjective:
    """The default objective on modes of jointid: peaks on a grid, paired in order with the measured modes, weighted least squares.

    `refined` refines each maximum of the grid: several points between the two neighbouring lines, then the vertex of the parabola through 1/|iωH|²
    at the best three of them, then again with three points closer to that vertex. Near a resonance 1/|iωH|² is a parabola, however narrow.
    """

    def __init__(self, bench, frequencies_hz, refined=False, chunk=4):
        self.bench, self.refined, self.chunk = bench, refined, chunk
        self.frequencies = frequencies_hz
        self.lines = Lines(bench, frequencies_hz[None, :], bench.nuts[:, None])
        self.low, self.high = 0.9 * bench.measured_hz.min(), 1.1 * bench.measured_hz.max()
        self.sd = np.hypot(0.29 * bench.resolution / bench.measured_hz, FREQUENCY_MODEL_ERROR)

    @staticmethod
    def grid(bench, step_hz=1.0):
        """Returns the lines of the search band."""
        low, high = 0.5 * bench.measured_hz.min(), 1.35 * bench.measured_hz.max()
        return np.arange(np.ceil(low / step_hz), np.floor(high / step_hz) + 1) * step_hz

    @staticmethod
    def fine_grid(bench, relative=1e-4):
        """Returns lines so dense that one lies within a relative distance of any frequency."""
        low, high = 0.5 * bench.measured_hz.min(), 1.35 * bench.measured_hz.max()
        return np.geomspace(low, high, int(np.ceil(np.log(high / low) / (2 * relative))) + 1)

    def peaks(self, places):
        """Returns frequencies, amplitudes and prominences (member, position, peak) in rising frequency, padded with infinite frequencies."""
        parts = [self._peaks(places[:, i : i + self.chunk]) for i in range(0, places.shape[1], self.chunk)]
        width = max(part[0].shape[2] for part in parts)
        fill = lambda array, value: np.pad(
            array, ((0, 0), (0, 0), (0, width - array.shape[2])), constant_values=value
        )
        return [
            np.concatenate([fill(part[i], value) for part in parts])
            for i, value in enumerate((np.inf, 1.0, 1.0))
        ]

    def _peaks(self, places):
        p = self.bench.parameters(self.bench.free_for_modes, places)
        square = self.lines.mobility_square(p)
        count, positions, lines = square.shape
        top = np.zeros(square.shape, dtype=bool)
        inner = square[..., 1:-1]
        np.logical_and(inner > square[..., :-2], inner >= square[..., 2:], out=top[..., 1:-1])
        flat = square.ravel()
        at = np.flatnonzero(top)
        row, line = np.divmod(at, lines)
        starts = np.searchsorted(row, np.arange(count * positions))
        order = np.arange(at.size) - starts[row]
        # The lowest line between a peak and its neighbours or the ends of the band.
        cuts = np.unique(np.concatenate([at, np.arange(count * positions) * lines]))
        lowest = np.minimum.reduceat(flat, cuts)
        here = np.searchsorted(cuts, at)
        valley = np.maximum(lowest[here - 1], lowest[here])
        frequency, height = self.frequencies[line], flat[at]
        if self.refined:
            frequency, height = self._refined(places, row, line)
        shape = (count * positions, (order.max() + 1) if at.size else 1)
        out = [np.full(shape, fill) for fill in (np.inf, 1.0, 1.0)]
        for array, values in zip(out, (frequency, np.sqrt(height), np.sqrt(height / valley))):
            array[row, order] = values
        return [array.reshape(count, positions, -1) for array in out]

    def _refined(self, places, row, line):
        member, position = np.divmod(row, len(self.bench.nuts))
        mine = self.bench.parameters(self.bench.free_for_modes, np.asarray(places)[:, member])
        mine = {name: np.reshape(value, -1) if np.ndim(value) else value for name, value in mine.items()}
        inverse = lambda points: (
            1 / Lines(self.bench, points, self.bench.nuts[position]).mobility_square(mine)
        )
        left, right = self.frequencies[line - 1], self.frequencies[line + 1]
        points = left + (right - left) * np.linspace(0, 1, ZOOM)[:, None]
        values = inverse(points)
        three = np.clip(values.argmin(axis=0), 1, ZOOM - 2) + np.array([[-1], [0], [1]])
        points, values = np.take_along_axis(points, three, 0), np.take_along_axis(values, three, 0)
        middle, width = np.clip(_vertex(points, values), points[0], points[2]), 0.1 * (points[2] - points[1])
        points = np.stack([middle - width, middle, middle + width])
        values = inverse(points)
        best = np.clip(_vertex(points, values), points[0] - 2 * width, points[2] + 2 * width)
        # 1/|iωH|² at the vertex by the same parabola, limited because it cannot fall far so close to the points.
        return best, 1 / np.maximum(_parabola(points, values, best), 0.2 * values.min(axis=0))

    def at(self, places):
        """Computes the objective at unit-cube coordinates (coordinate, member)."""
        frequency, amplitude, prominence = self.peaks(places)
        bench = self.bench
        count, positions, found = frequency.shape
        unexpected = (
            (prominence >= bench.least_prominence) & (frequency >= self.low) & (frequency <= self.high)
        )
        alone = np.where(unexpected, MISSING, 0.0) ** 2
        missing = (MISSING / FREQUENCY_MODEL_ERROR) ** 2
        # Order-preserving pairing with the least sum of squares. Each state holds that sum, cost, pairs, Σ ln ratio, Σ (ln ratio)².
        start = np.zeros((5, count, positions))
        above = [start]
        for j in range(found):
            state = above[-1].copy()
            state[0] += alone[..., j]
            state[1] += np.where(unexpected[..., j], missing, 0.0)
            above.append(state)
        for i in range(bench.measured_hz.shape[1]):
            hz, level, sd = bench.measured_hz[:, i], bench.measured_amplitude[:, i], self.sd[:, i]
            error = np.minimum(frequency / hz[:, None] - 1, 1e3)
            ratio = np.log(level[:, None] / amplitude)
            state = above[0].copy()
            state[0] += MISSING**2
            state[1] += missing
            row = [state]
            for j in range(found):
                pair = above[j].copy()
                e, r = error[..., j], ratio[..., j]
                pair[0] += e * e
                pair[1] += (e / sd) ** 2
                pair[2] += 1
                pair[3] += r
                pair[4] += r * r
                lost = above[j + 1][0] + MISSING**2
                over = row[-1][0] + alone[..., j]
                best = pair
                take = lost < best[0]
                if take.any():
                    other = above[j + 1].copy()
                    other[0] += MISSING**2
                    other[1] += missing
                    best = np.where(take, other, best)
                take = over < best[0]
                if take.any():
                    other = row[-1].copy()
                    other[0] += alone[..., j]
                    other[1] += np.where(unexpected[..., j], missing, 0.0)
                    best = np.where(take, other, best)
                row.append(best)
            above = row
        _, cost, pairs, logs, squares = above[-1].sum(axis=2)
        # The gain is unknown: subtract the mean logarithm.
        return cost + (squares - logs**2 / np.maximum(pairs, 1)) / AMPLITUDE_SD**2


def _divided(x, y):
    first, second = (y[1] - y[0]) / (x[1] - x[0]), (y[2] - y[1]) / (x[2] - x[1])
    return first, (second - first) / (x[2] - x[0])


def _vertex(x, y):
    """Returns the minimum of the parabola through three points."""
    first, second = _divided(x, y)
    bends = second > 0
    return np.where(bends, 0.5 * (x[0] + x[1]) - 0.5 * first / np.where(bends, second, 1), x[1])


def _parabola(x, y, at):
    first, second = _divided(x, y)
    return y[0] + (at - x[0]) * (first + second * (at - x[1]))


class FrfObjective:
    """χ² of whole FRFs, three positions × 1,000 lines, with 2 % noise and 1 % model error as weighted by jointid, measured at the start values.

    `noise` adds a deterministic substitute for noise of 2 %, identical in benches/side_by_side.rs.
    """

    def __init__(self, bench, noise=False):
        self.bench = bench
        self.names = list(bench.start)
        self.lines = Lines(bench, np.arange(6.0, 1006.0)[None, :], bench.nuts[:, None])
        self.measured = self.lines.receptance(bench.start)
        if noise:
            phase = np.arange(self.measured.size, dtype=float).reshape(self.measured.shape) ** 2
            self.measured = self.measured * (1 + 0.02 * np.cos(phase) + 0.02j * np.sin(1.1 * phase))
        self.weight = 1 / (0.02**2 / 2 + 0.01**2)

    def at(self, place):
        """Computes χ² for one member: 3,000 lines fit the cache, more would not."""
        return self.of(self.bench.parameters(self.names, np.reshape(place, (-1, 1))))

    def of(self, parameters):
        """Computes χ² for parameter values by name."""
        above, below = self.lines.fraction(parameters)
        ratio = self.measured * below / above
        # The principal value needs no unwrapping; ln of a real and arctan2 are faster than ln of a complex number.
        size = 0.5 * np.log(ratio.real**2 + ratio.imag**2)
        angle = np.arctan2(ratio.imag, ratio.real)
        return self.weight * (np.vdot(size, size) + np.vdot(angle, angle))
