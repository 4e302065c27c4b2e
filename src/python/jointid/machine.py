"""Machines as described."""

from __future__ import annotations

import os
from typing import NamedTuple

from . import _arrays, _core


class MachineParameter(NamedTuple):
    """A parameter of a machine: its unit, start value and plausible range."""

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
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._core = _core.Machine.read(_arrays.path("machine", path))

    @classmethod
    def from_text(cls, text: str, name: str = "machine.toml") -> Machine:
        """Makes a machine from the text of its description, under a name for messages and documents."""
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

    def __reduce__(self):
        return _machine_from_text, (self.text, self.path)

    def __repr__(self) -> str:
        return f"Machine({self.path!r}: {self.title})"


def _machine_from_text(text: str, name: str) -> Machine:
    return Machine.from_text(text, name)
