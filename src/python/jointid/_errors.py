"""Exceptions of the package."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import wraps
from types import FunctionType
from typing import Any


class InputError(ValueError):
    """An argument, a file or a key of a file is wrong; the message says what was found and what to write instead.

    Attributes
    ----------
    file : str or None
        File, folder or measurement set in which the fault lies.
    line : int or None
        Line of the file, from 1.
    key : str or None
        Key of the file, record, or argument.
    """

    def __init__(
        self, message: str, file: str | None = None, line: int | None = None, key: str | None = None
    ) -> None:
        super().__init__(message)
        self.file, self.line, self.key = file, line, key

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str | None, int | None, str | None]]:
        return type(self), (str(self), self.file, self.line, self.key)


class StoppedError(RuntimeError):
    """The work was stopped before there was a result."""


def argument(key: str, fault: str) -> InputError:
    """The exception of an argument: its name, what was found, and what to write instead."""
    return InputError(f"{key}: {fault}", key=key)


def needs(module: str, extra: str, purpose: str) -> ImportError:
    """The exception of an optional package that is not installed."""
    return ImportError(f"{purpose} needs {module}, which is not installed: pip install 'jointid[{extra}]'")


def _without_inner_frames(function: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(function)
    def call(*given: Any, **named: Any) -> Any:
        try:
            return function(*given, **named)
        except InputError as refused:
            raise refused.with_traceback(None) from None

    return call


def shorten_tracebacks(public: Iterable[Any]) -> Iterable[Any]:
    """Returns public functions, and classes with their public methods, so that what they raise about wrong input ends at the caller's line: where in
    the package it was found says nothing to a user."""
    for made in public:
        if isinstance(made, FunctionType):
            yield _without_inner_frames(made)
            continue
        if isinstance(made, type) and not issubclass(made, Exception):
            for name, member in list(vars(made).items()):
                if name.startswith("_") and name != "__init__":
                    continue
                if isinstance(member, FunctionType):
                    setattr(made, name, _without_inner_frames(member))
                elif isinstance(member, classmethod):
                    setattr(made, name, classmethod(_without_inner_frames(member.__func__)))
        yield made
