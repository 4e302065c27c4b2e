"""Figures of results with matplotlib; every function returns the figure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from . import _arrays
from ._errors import argument
from ._optional import optional

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from .diagnosis import Diagnosis
    from .identification import Identification
    from .results import Peaks, Prediction

# Colours that remain apart for colour-blind readers (Okabe and Ito).
MEASURED, BEFORE, AFTER, OTHER = "#000000", "#D55E00", "#0072B2", "#999999"
UNITS = {"receptance": "m/N", "mobility": "(m/s)/N", "accelerance": "(m/s²)/N"}

# Phase of a resonance of a driving point (°): noise about its limits must not jump by a turn.
PHASES = {"receptance": -90, "mobility": 0, "accelerance": 90}


def _phase(values: np.ndarray, middle: float) -> np.ndarray:
    """Phase within half a turn about its middle (°)."""
    return (np.degrees(np.angle(values)) - middle + 180) % 360 + middle - 180


def _panels(
    ax: Any, rows: int = 1, columns: int = 1, size: tuple[float, float] = (7.0, 4.0), **options: Any
) -> tuple[Figure, np.ndarray]:
    """The figure and its axes (rows, columns): the given ones, else those of a new figure."""
    if ax is not None:
        given = np.asarray(ax, dtype=object).ravel()
        if given.size != rows * columns or not all(hasattr(axis, "plot") for axis in given):
            raise argument(
                "ax",
                f"has {given.size} axes, and the figure {rows * columns} panels; give plt.subplots({rows}, {columns})[1]",
            )
        return given[0].figure, given.reshape(rows, columns)
    plt = optional("matplotlib.pyplot", "plot", "a figure")
    figure, axes = plt.subplots(rows, columns, figsize=size, layout="constrained", squeeze=False, **options)
    # A notebook shows the returned figure, and would show an open one again.
    plt.close(figure)
    return figure, axes


def identification(found: Identification, positions: list[str] | None = None, ax: Any = None) -> Figure:
    """Measured FRFs with the machine before and after; natural frequencies over the positions where no FRF was fitted."""
    document = found.document
    if document["settings"]["objective"] == "frf":
        return _frfs(found, positions, ax)
    if document.get("records"):
        return _records(found, positions, ax)
    return _frequencies(found, positions, ax)


def _frfs(found: Identification, positions: list[str] | None, ax: Any) -> Figure:
    study = found.study
    measured = study.measurements.frfs
    if positions is not None:
        _arrays.unknown("positions", positions, measured)
        measured = {name: measured[name] for name in positions}
    figure, axes = _panels(ax, len(measured), 2, (9.0, 2.3 * len(measured) + 0.6), sharex=True)
    for (name, frf), (magnitude, phase) in zip(measured.items(), axes, strict=True):
        lines = frf.frequency_hz
        place = {"positions": frf.position} if frf.position is not None else {}
        common: dict[str, Any] = {
            "response": frf.response,
            "excitation": frf.excitation,
            "quantity": frf.quantity,
        } | place
        middle = PHASES[frf.quantity]
        curves = [("measured", frf.value, MEASURED, "-", 0.8)]
        for label, machine, colour, style in (("before", study, BEFORE, "--"), ("after", found, AFTER, "-")):
            values = np.atleast_2d(machine.frf(lines, **common))[0]
            curves.append((label, values, colour, style, 1.4))
        for label, values, colour, style, width in curves:
            magnitude.semilogy(lines, np.abs(values), style, color=colour, lw=width, label=label)
            phase.plot(lines, _phase(values, middle), style, color=colour, lw=width)
        role = document_role(found, frf.position or name)
        magnitude.set_title(f"{name}{role}", loc="left", fontsize="medium")
        magnitude.set_ylabel(f"|H|  {UNITS[frf.quantity]}")
        phase.set_ylabel("phase  °")
        phase.set_yticks([middle - 90, middle, middle + 90])
    axes[0, 0].legend(ncols=3, fontsize="small", loc="best")
    for axis in axes[-1]:
        axis.set_xlabel("frequency  Hz")
    return figure


def document_role(found: Identification, name: str) -> str:
    """How a position entered an identification, for a title."""
    row = found.document["positions"].get(name)
    return "" if row is None else {"fit": " (fitted)", "held_out": " (held out)"}.get(row["role"], "")


def _frequencies(found: Identification, positions: list[str] | None, ax: Any) -> Figure:
    rows = found.document["positions"]
    names = list(rows) if positions is None else positions
    _arrays.unknown("positions", names, rows)
    orders = sorted({order["order"] for name in names for order in rows[name]["orders"]})
    rows_of_panels = max(len(orders), 1)
    figure, axes = _panels(ax, rows_of_panels, 1, (7.0, 1.7 * rows_of_panels + 0.8), sharex=True)
    for order, axis in zip(orders, axes[:, 0], strict=False):
        of: dict[str, dict[str, Any]] = {
            name: next((o for o in rows[name]["orders"] if o["order"] == order), {}) for name in names
        }
        measured = [of[name].get("measured_hz") or np.nan for name in names]
        predicted = [of[name].get("predicted_hz") or np.nan for name in names]
        axis.plot(names, measured, "o", color=MEASURED, mfc="none", ms=8, label="measured")
        fitted = [at for at, name in enumerate(names) if rows[name]["role"] == "fit"]
        held = [at for at in range(len(names)) if at not in fitted]
        for which, mark, label in (
            (fitted, "x", "identified, fitted position"),
            (held, "+", "identified, held-out position"),
        ):
            if which:
                axis.plot(
                    [names[at] for at in which],
                    [predicted[at] for at in which],
                    mark,
                    color=AFTER,
                    ms=8,
                    mew=2,
                    label=label,
                )
        axis.set_ylabel(f"order {order}  Hz")
        axis.margins(x=0.08, y=0.3)
    axes[0, 0].legend(fontsize="small", ncols=3, loc="lower left", bbox_to_anchor=(0, 1))
    axes[-1, 0].set_xlabel("position")
    return figure


def _records(found: Identification, positions: list[str] | None, ax: Any) -> Figure:
    rows = found.document["positions"]
    names = list(rows) if positions is None else positions
    _arrays.unknown("positions", names, rows)
    figure, axes = _panels(ax, size=(7.0, 0.4 * len(names) + 1.6))
    colours = [AFTER if rows[name]["role"] == "fit" else BEFORE for name in names]
    axes[0, 0].barh(names, [100 * rows[name]["gap"] for name in names], color=colours)
    axes[0, 0].invert_yaxis()
    axes[0, 0].set_xlabel("relative force error  %   (blue: fitted, orange: held out)")
    return figure


def profile(found: Identification, parameter: str, points: int | ArrayLike, ax: Any) -> Figure:
    """Profile of the objective over a parameter, with the 95 % interval and the estimate."""
    values, costs = found.profile(parameter, points)
    row = found.parameters[parameter]
    figure, axes = _panels(ax, size=(6.0, 3.6))
    axis: Axes = axes[0, 0]
    axis.plot(values, costs - found.cost, "o-", color=AFTER, ms=4)
    if row.interval95 is not None:
        axis.axvspan(*row.interval95, color=AFTER, alpha=0.15, label="95 % interval")
    axis.axvline(row.value, color=MEASURED, lw=0.8, label="estimate")
    axis.set_xlabel(f"{parameter}  {row.unit}")
    axis.set_ylabel("cost above the minimum")
    if values.min() > 0 and values.max() / values.min() > 10:
        axis.set_xscale("log")
    axis.legend(fontsize="small")
    return figure


def diagnosis(found: Diagnosis, ax: Any) -> Figure:
    """Map of the gap by position and band, and the share that each candidate closes."""
    from matplotlib.colors import LogNorm

    cells = found.document.get("residual_map", [])
    tried = [
        effect for effect in found.effects.values() if effect.status == "tried" and effect.closed is not None
    ][:10]
    columns = 2 if cells else 1
    figure, axes = _panels(ax, 1, columns, (4.8 * columns + 1.0, 4.2))
    if cells:
        _residual_map(axes[0, 0], cells, LogNorm)
    axis: Axes = axes[0, -1]
    names = [effect.id for effect in tried]
    shares = [100 * effect.closed for effect in tried if effect.closed is not None]
    axis.barh(names, shares, color=[AFTER if effect.selected else OTHER for effect in tried])
    for at, effect in enumerate(tried):
        if effect.closed95 is not None:
            axis.plot([100 * end for end in effect.closed95], [at, at], color=MEASURED, lw=2)
    # One candidate that spoils everything would hide the others.
    axis.set_xlim(min(0.0, max(-105.0, min(shares, default=0.0))), 105)
    axis.axvline(0, color=MEASURED, lw=0.8)
    axis.invert_yaxis()
    axis.set_xlabel("share of the held-out gap that it closes  %")
    named = " or ".join(found.verdict.effects)
    axis.set_title(
        f"verdict: {found.verdict.kind}{f', {named}' if named else ''}", loc="left", fontsize="medium"
    )
    return figure


def _residual_map(axis: Axes, cells: list[dict[str, Any]], norm: Any) -> None:
    channels = {cell["channel"] for cell in cells}
    rows = list(dict.fromkeys((cell["position"], cell["channel"]) for cell in cells))
    edges = sorted({cell["from_hz"] for cell in cells} | {cell["to_hz"] for cell in cells})
    gaps = np.full((len(rows), len(edges) - 1), np.nan)
    for cell in cells:
        gaps[
            rows.index((cell["position"], cell["channel"])),
            edges.index(cell["from_hz"]) : edges.index(cell["to_hz"]),
        ] = cell["gap"]
    shown = np.nan_to_num(gaps, nan=1.0)
    low, high = float(shown.min()), float(shown.max())
    scale = norm(max(low, high / 1e3), max(high, 1.001 * low)) if high > 0 else None
    image = axis.pcolormesh(edges, np.arange(len(rows) + 1), gaps, norm=scale, cmap="viridis")
    axis.set_yticks(
        np.arange(len(rows)) + 0.5,
        [name if len(channels) == 1 else f"{name} {channel}" for name, channel in rows],
    )
    axis.invert_yaxis()
    if edges[0] > 0 and edges[-1] / edges[0] > 20:
        axis.set_xscale("log")
    axis.set_xlabel("frequency  Hz")
    axis.set_title("gap by position and band", loc="left", fontsize="medium")
    axis.figure.colorbar(image, ax=axis)


def modes(
    found: Identification, nut_m: float | None, position: str | None, max_hz: float, ax: Any
) -> Figure:
    """Mode shapes of the identified machine: a row of panels for displacements (m) and one for angles (rad), each relative to its largest."""
    if nut_m is None and position is None:
        place = next(iter(found.study.measurements.nut_m), None)
        position = place if place is not None and found.study.measurements.nut_m[place] is not None else None
    computed = found.study.with_machine(found.machine()).modes(nut_m=nut_m, position=position, max_hz=max_hz)
    elastic = np.flatnonzero(computed.frequency_hz > 0)[:8]
    if not elastic.size:
        raise argument(
            "max_hz", f"is {max_hz}; the machine has no elastic mode below it; write a higher frequency"
        )
    units = [unit for unit in ("m", "rad") if unit in computed.units.values()]
    names = {unit: [point for point in computed.points if computed.units[point] == unit] for unit in units}
    height = sum(0.28 * len(names[unit]) + 0.8 for unit in units) + 0.8
    options = {} if ax is not None else {"height_ratios": [len(names[unit]) + 1 for unit in units]}
    figure, axes = _panels(
        ax, len(units), len(elastic), (1.5 * len(elastic) + 2.0, height), sharey="row", **options
    )
    for unit, row in zip(units, axes, strict=True):
        columns = [computed.points.index(point) for point in names[unit]]
        for mode, axis in zip(elastic, row, strict=True):
            shape = computed.shapes[mode, columns]
            axis.barh(names[unit], shape / max(np.abs(shape).max(), 1e-300), color=AFTER)
            axis.axvline(0, color=MEASURED, lw=0.8)
            axis.set_xlim(-1.1, 1.1)
        row[0].invert_yaxis()
        row[0].set_ylabel({"m": "displacement", "rad": "angle"}[unit])
    for mode, axis in zip(elastic, axes[0], strict=True):
        axis.set_title(f"{computed.frequency_hz[mode]:.1f} Hz", fontsize="medium")
    if ax is None:
        figure.supxlabel("relative to the largest of its kind", fontsize="medium")
    return figure


def prediction(found: Prediction, ax: Any) -> Figure:
    """Frequencies of the peaks over the nut position, with their 95 % intervals."""
    places = sorted(found.positions.values(), key=lambda place: place["nut_m"] or 0.0)
    peaks = [
        (place["nut_m"] or 0.0, mode)
        for place in places
        for mode in place["modes"]
        if mode["frequency_hz"] is not None
    ]
    orders = sorted({mode["order"] for _, mode in peaks})[:8]
    figure, axes = _panels(ax, len(orders), 1, (7.0, 1.5 * len(orders) + 0.8), sharex=True)
    for order, axis in zip(orders, axes[:, 0], strict=True):
        of = [(nut, mode) for nut, mode in peaks if mode["order"] == order]
        nuts = [nut for nut, _ in of]
        axis.plot(nuts, [mode["frequency_hz"] for _, mode in of], "o-", color=AFTER, ms=4)
        axis.fill_between(
            nuts, *np.transpose([mode["frequency95"] for _, mode in of]), color=AFTER, alpha=0.25
        )
        axis.set_ylabel(f"order {order}  Hz")
    axes[0, 0].set_title("natural frequencies with 95 % intervals", loc="left", fontsize="medium")
    axes[-1, 0].set_xlabel("nut position  m")
    return figure


def stabilisation(found: Peaks, record: str | None, ax: Any) -> Figure:
    """Stabilisation diagram of an FRF over its magnitude, with the regular modes."""
    frfs = found._measurements.frfs
    name = next(iter(frfs)) if record is None else record
    poles = found.stabilisation(name)
    frf = frfs[name]
    figure, axes = _panels(ax, size=(8.0, 4.4))
    axis: Axes = axes[0, 0]
    for stable, colour, mark, label in ((False, OTHER, ".", "pole"), (True, AFTER, "o", "stable pole")):
        some = poles[poles["stable"] == stable]
        axis.plot(some["frequency_hz"], some["order"], mark, color=colour, ms=4, label=label, ls="")
    for mode in found.document["modes"]:
        if mode["regular"] and name in mode["records"]:
            axis.axvline(mode["records"][name]["frequency_hz"], color=BEFORE, lw=1, ls="--")
    axis.set_xlim(frf.frequency_hz[0], frf.frequency_hz[-1])
    axis.set_xlabel("frequency  Hz")
    axis.set_ylabel("polynomial order")
    axis.set_title(f"{name}; dashed: modes regular over the positions", loc="left", fontsize="medium")
    axis.legend(fontsize="small", loc="upper right")
    behind = axis.twinx()
    behind.semilogy(frf.frequency_hz, np.abs(frf.value), color=MEASURED, lw=0.8)
    behind.set_ylabel(f"|H|  {UNITS[frf.quantity]}")
    return figure
