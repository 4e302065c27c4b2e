"""Diagnoses: where model and machine disagree, and which effect the model lacks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from . import _html
from ._optional import pandas_for
from .machine import Machine
from .parameters import Interval, interval_of
from .results import Document, measured

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .study import Study


@dataclass(frozen=True)
class Effect:
    """A candidate effect of a diagnosis; `closed` is the share of the squared held-out gap above the noise floor that it closes.

    `open`: its best fit was found by a single search, so that a deeper minimum may exist.

    >>> diagnosis.effects["rotor-hold"].status
    'tried'
    """

    id: str
    status: str
    closed: float | None
    closed95: Interval | None
    p_value: float | None
    gap_held_out_before: float | None
    gap_held_out_after: float | None
    parameters: Mapping[str, float]
    selected: bool
    description: str | None
    open: bool


@dataclass(frozen=True)
class Verdict:
    """The verdict of a diagnosis: its kind, the effects or faults that it names, why, and whether held-out data confirm it (None: nothing is held out).

    >>> "rotor-hold" in diagnosis.verdict.effects
    True
    """

    kind: str
    effects: tuple[str, ...]
    reason: str
    next_measurement: str | None
    faults: tuple[str, ...]
    confirmed: bool | None


class Diagnosis(Document):
    """Where model and machine disagree, which effect the model lacks, and how far including it closes the gap.

    >>> diagnosis.verdict.kind in ("effect", "ambiguous")
    True
    """

    def __init__(self, text: str, study: Study) -> None:
        super().__init__(text)
        self.study = study

    @cached_property
    def verdict(self) -> Verdict:
        """The verdict."""
        row = self.document["verdict"]
        faults, effects = tuple(row.get("faults", ())), tuple(row["effects"])
        return Verdict(
            row["kind"], effects, row["reason"], row.get("next_measurement"), faults, row.get("confirmed")
        )

    @cached_property
    def effects(self) -> dict[str, Effect]:
        """All candidates by id, best first."""
        return {
            row["id"]: Effect(
                id=row["id"],
                status=row["status"],
                closed=row["closed"],
                closed95=interval_of(row.get("closed95")),
                p_value=row["p_value"],
                gap_held_out_before=row["gap_held_out_before"],
                gap_held_out_after=row["gap_held_out_after"],
                parameters=row["parameters"],
                selected=row["selected"],
                description=row.get("description"),
                open=row.get("open", False),
            )
            for row in self.document["effects"]
        }

    @property
    def where(self) -> list[dict[str, Any]]:
        """Locations of the discrepancy, best first."""
        return self.document["where"]

    @property
    def gap(self) -> dict[str, Any]:
        """Gaps of the machine as described."""
        return self.document["gap"]

    def apply(self) -> Study:
        """Returns the study of the machine with the effect that the verdict names.

        Raises
        ------
        InputError
            The verdict names no effect, or more than one explanation.

        Examples
        --------
        >>> try:
        ...     study_with_effect = diagnosis.apply()
        ... except jd.InputError as error:
        ...     print(diagnosis.verdict.kind)
        ambiguous
        """
        text = self.study._core.machine_of_diagnosis(self.json)
        return self.study.with_machine(Machine.from_text(text, self.study.machine.path))

    def to_frame(self) -> pandas.DataFrame:
        """One row a candidate that was tried, best first.

        >>> "closed" in diagnosis.to_frame()
        True
        """
        tried = [vars(effect) for effect in self.effects.values() if effect.status == "tried"]
        return pandas_for("a table").DataFrame(tried).set_index("id")

    def plot(self, *, ax: Axes | Any = None) -> Figure:
        """Draws where the gap lies (position by band), and the share that each candidate closes.

        >>> figure = diagnosis.plot()
        """
        from . import plot

        return plot.diagnosis(self, ax)

    def _parts(self) -> list[str]:
        verdict = self.verdict
        named = {"verdict": verdict.kind, "effects": " or ".join(verdict.effects) or "–", "reason": verdict.reason}
        named |= {"next measurement": verdict.next_measurement} if verdict.next_measurement else {}
        rows = [
            (effect.id, *measured(effect.closed, effect.closed95), f"{effect.p_value or 1:.2g}")
            for effect in self.effects.values()
            if effect.status == "tried"
        ]
        columns = ("effect", "closed share of the gap", "95 % interval", "p")
        return [_html.pairs(named), _html.table(columns, rows)]

    def __reduce__(self) -> tuple[Any, ...]:
        return Diagnosis, (self.json, self.study)

    def __repr__(self) -> str:
        names = " or ".join(self.verdict.effects) or "–"
        return f"<Diagnosis: {self.verdict.kind}, {names}: {self.verdict.reason}>"
