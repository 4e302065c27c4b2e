"""Machines as described."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _core, _html
from ._frf import frf_of
from ._progress import Callback
from .simulation import Modes, Motion, MotionSettings, modes_of, motion_of, stiffness_of

if TYPE_CHECKING:
    from typing_extensions import Unpack


class MachineParameter(NamedTuple):
    """A parameter of a machine: its unit, start value and plausible range.

    >>> machine.parameters["k_n"].unit
    'N/m'
    """

    unit: str
    start: float
    lower: float
    upper: float


class Machine:
    """A machine as described by a file in TOML. Pickles as its text.

    Parameters
    ----------
    path : path
        File of the description; the descriptions in `configs`, such as `configs/tian.toml`, are built in.

    Raises
    ------
    InputError
        The file cannot be read, or does not describe a machine; `file`, `line` and `key` say where.

    Examples
    --------
    >>> machine = jd.Machine("configs/tian.toml")
    >>> machine.points[:2]
    ['table', 'rotor']
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._core = _core.Machine.read(_arrays.path("machine", path))

    @classmethod
    def from_text(cls, text: str, name: str = "machine.toml") -> Machine:
        """Makes a machine from the text of its description, under a name for messages and documents.

        >>> jd.Machine.from_text(machine.text, "axis.toml").path
        'axis.toml'
        """
        made = cls.__new__(cls)
        made._core = _core.Machine.from_text(_arrays.name("name", name), _arrays.name("text", text))
        return made

    @property
    def path(self) -> str:
        """File or name of the description."""
        return self._core.path

    @property
    def text(self) -> str:
        """The description (TOML)."""
        return self._core.text

    @property
    def title(self) -> str:
        """Title of the machine."""
        return self._core.title

    @property
    def points(self) -> list[str]:
        """Names of the points, at which responses and excitations lie."""
        return self._core.points

    @property
    def parameters(self) -> dict[str, MachineParameter]:
        """Parameters by id."""
        return {row[0]: MachineParameter(*row[1:]) for row in self._core.parameters}

    @property
    def warnings(self) -> list[str]:
        """Warnings about the description, such as implausible numbers."""
        return self._core.warnings

    def frf(
        self,
        frequency_hz: ArrayLike,
        *,
        response: str,
        excitation: str,
        nut_m: float | Sequence[float] | None = None,
        quantity: str = "receptance",
        closed_loop: bool = False,
    ) -> NDArray[np.complex128]:
        """Computes FRFs at the start values of the parameters, H = response / force with e^{+iωt}.

        Parameters
        ----------
        frequency_hz : (lines,) array
            Frequencies in Hz, above 0.
        response, excitation : str
            Points of the machine.
        nut_m : float or (places,) sequence
            Nut positions from the left end of the screw (m); mid-stroke by default.
        quantity : {"receptance", "mobility", "accelerance"}
            In m/N, (m/s)/N or (m/s²)/N.
        closed_loop : bool
            Whether the loops of the drive are closed.

        Returns
        -------
        (places, lines) array of complex numbers; (lines,) for one nut position, and for mid-stroke.

        Raises
        ------
        InputError
            A place is outside the screw, a point is unknown, a frequency is not above 0.

        Examples
        --------
        >>> machine.frf([20.0, 50.0], nut_m=[0.6, 1.2], response="table", excitation="table").shape
        (2, 2)
        """
        values = frf_of(
            self._core.study(),
            quantity,
            frequency_hz,
            nut_m,
            None,
            response,
            excitation,
            quantity,
            closed_loop,
        )
        return values[0] if nut_m is None else values

    def modes(self, *, nut_m: float | None = None, max_hz: float = 1000.0) -> Modes:
        """Computes undamped natural frequencies and mode shapes at the start values, up to `max_hz`; mid-stroke by default.

        >>> machine.modes(nut_m=0.9, max_hz=200.0).frequency_hz.round(1).tolist()
        [52.4, 157.6]
        """
        return modes_of(self._core.study(), nut_m, None, max_hz)

    def static_stiffness(
        self, point: str, *, nut_m: float | Sequence[float] | None = None
    ) -> NDArray[np.float64]:
        """Computes the static stiffness (N/m or N·m/rad) of a point at each nut position (m), at the start values: an array, or a number for one position
        and for mid-stroke.

        >>> machine.static_stiffness("table", nut_m=[0.6, 1.2]).shape
        (2,)
        """
        return stiffness_of(self._core.study(), point, nut_m, None)

    def simulate_motion(
        self,
        *,
        threads: int | None = None,
        progress: bool | Callback | None = None,
        **motion: Unpack[MotionSettings],
    ) -> Motion:
        """Simulates the driven axis at the start values, with friction, backlash and loops: a travel from rest to rest, a sine, or a table.

        The keys of `motion` are those of :class:`jointid.simulation.MotionSettings`.

        Raises
        ------
        InputError
            The machine has no drive; a command is beyond the stroke; a number is out of its range.

        Examples
        --------
        >>> drive = jd.Machine("configs/emps.toml")
        >>> drive.simulate_motion(travel_m=0.05, and_back=True).is_stable
        True
        """
        return motion_of(self._core.study(), motion, (None, None), threads, progress)

    def _repr_html_(self) -> str:
        rows = [
            (name, f"{row.start:.4g}", row.unit, f"{row.lower:.4g} … {row.upper:.4g}")
            for name, row in self.parameters.items()
        ]
        parameters = _html.table(("parameter", "start", "unit", "range"), rows)
        return _html.page("Machine", f"{self.title} ({self.path})", [parameters], self.warnings)

    def __reduce__(self) -> tuple[Any, ...]:
        return _machine_from_text, (self.text, self.path)

    def __repr__(self) -> str:
        return f"Machine({self.path!r}: {self.title})"


def _machine_from_text(text: str, name: str) -> Machine:
    return Machine.from_text(text, name)
