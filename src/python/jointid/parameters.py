"""Identified parameters, and machines drawn about them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _html
from ._optional import optional, pandas_for

if TYPE_CHECKING:
    import pandas

Interval = tuple[float, float]


def interval_of(ends: Sequence[float] | None) -> Interval | None:
    """An interval of a document."""
    return None if ends is None else (ends[0], ends[1])


@dataclass(frozen=True)
class Parameter:
    """An identified parameter, in `unit`.

    `interval95` is the 95 % interval (None where none was computed), `intervals95` its parts where the data accept several ranges. `identifiable` is None
    for a parameter that was not fitted, or whose value depends on what `depends_on` lists (`depends_on_discrepancy`).

    >>> found.parameters["k_n"].interval95[0] < found.parameters["k_n"].value
    True
    """

    value: float
    unit: str
    lower: float
    upper: float
    interval95: Interval | None
    identifiable: bool | None
    fitted: bool
    depends_on_discrepancy: bool = False
    intervals95: tuple[Interval, ...] = ()
    description: str = ""
    depends_on: tuple[str, ...] = ()

    @classmethod
    def _of(cls, row: Mapping[str, Any]) -> Parameter:
        return cls(
            value=row["value"],
            unit=row["unit"],
            lower=row["lower"],
            upper=row["upper"],
            interval95=interval_of(row.get("interval95")),
            identifiable=row.get("identifiable"),
            fitted=row["fitted"],
            depends_on_discrepancy=row.get("depends_on_discrepancy", False),
            depends_on=tuple(row.get("depends_on", ())),
            intervals95=tuple((low, high) for low, high in row.get("intervals95", ())),
            description=row.get("description", ""),
        )

    def _status(self) -> str:
        """Whether it is identifiable, in words."""
        if not self.fitted:
            return "held"
        depends = f"depends on {'; '.join(self.depends_on) or 'what the model lacks'}"
        return {True: "identifiable", False: "not identifiable", None: depends}[self.identifiable]

    def _ends(self) -> str:
        """The 95 % interval as text; empty where there is none."""
        return f"{self.interval95[0]:.4g} … {self.interval95[1]:.4g}" if self.interval95 else ""


class Parameters(dict[str, Parameter]):
    """Parameters by id.

    >>> sorted(found.parameters)[:2]
    ['c_al', 'c_ar']
    """

    def to_frame(self) -> pandas.DataFrame:
        """One row a parameter: value, unit, interval_low, interval_high, identifiable, …

        >>> found.parameters.to_frame().loc["k_n", "unit"]
        'N/m'
        """
        rows = []
        for name, parameter in self.items():
            low, high = parameter.interval95 or (None, None)
            keys = ("identifiable", "depends_on_discrepancy", "fitted", "lower", "upper", "description")
            row = {
                "parameter": name,
                "value": parameter.value,
                "unit": parameter.unit,
                "interval_low": low,
                "interval_high": high,
            }
            rows.append(row | {key: getattr(parameter, key) for key in keys})
        return pandas_for("a table").DataFrame(rows).set_index("parameter")

    def _repr_html_(self) -> str:
        rows = [
            (name, f"{row.value:.4g}", row.unit, row._ends(), row._status()) for name, row in self.items()
        ]
        return _html.table(("parameter", "value", "unit", "95 % interval", ""), rows)


@dataclass(frozen=True)
class Draws:
    """Machines that the data leave possible.

    Attributes
    ----------
    parameters : list of str
        Ids of parameters, and names of tolerances.
    values : (draws, parameters) array
        Their values, each in its unit.
    minimum : (draws,) array
        Number of the minimum about which a machine was drawn, from 0, the best.
    weight : (draws,) array
        Likelihood of that minimum over that of the best, exp(−Δχ²/2): 1 for draws about the best.

    Examples
    --------
    >>> drawn = of_taps.draws(3)
    >>> drawn.values.shape == (drawn.minimum.size, len(drawn.parameters))
    True
    """

    parameters: list[str]
    values: NDArray[np.float64]
    minimum: NDArray[np.int64]
    weight: NDArray[np.float64]

    def to_frame(self) -> pandas.DataFrame:
        """One row a draw: minimum, weight, and the value of every parameter.

        >>> list(of_taps.draws(3).to_frame())[:3]
        ['minimum', 'weight', 'c_al']
        """
        table = pandas_for("a table").DataFrame(self.values, columns=self.parameters)
        table.insert(0, "weight", self.weight)
        table.insert(0, "minimum", self.minimum)
        return table

    def to_arviz(self) -> Any:
        """The draws as ArviZ's InferenceData: a chain for each minimum, whose weight is in `sample_stats`.

        >>> of_taps.draws(3).to_arviz().posterior["k_n"].dims
        ('chain', 'draw')
        """
        arviz = optional("arviz", "arviz", "InferenceData")
        chains = int(self.minimum.max(initial=0)) + 1

        def by_chain(column: NDArray[Any]) -> NDArray[Any]:
            return np.stack([column[self.minimum == chain] for chain in range(chains)])

        groups = {
            "posterior": {
                name: by_chain(column) for name, column in zip(self.parameters, self.values.T, strict=True)
            },
            "sample_stats": {"weight": by_chain(self.weight)},
        }
        # ArviZ 1 takes the groups as one dictionary, earlier versions by name.
        takes_groups = int(arviz.__version__.partition(".")[0]) >= 1
        return arviz.from_dict(groups) if takes_groups else arviz.from_dict(**groups)
