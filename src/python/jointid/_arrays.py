"""Checks of arrays and other arguments; every message names the argument."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import argument

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


def _array(key: str, given: Any) -> np.ndarray:
    masked = int(np.ma.getmaskarray(given).sum()) if isinstance(given, np.ma.MaskedArray) else 0
    if masked:
        raise argument(
            key,
            f"is a masked array with {masked} masked entries; leave these entries out of all arrays of the record: x[~mask].data",
        )
    try:
        array = np.asarray(given)
    except (ValueError, TypeError) as fault:
        raise argument(key, f"is no array of numbers ({fault})") from None
    if array.dtype == object:
        raise argument(
            key,
            "is an array of Python objects, or has rows of unlike length; give numbers: np.asarray(x, dtype=float)",
        )
    if array.dtype.kind not in "iufc":
        raise argument(key, f"has the type {array.dtype}; give numbers")
    if array.ndim != 1:
        raise argument(key, f"has the shape {array.shape}; give one dimension, such as x.ravel()")
    if array.size == 0:
        raise argument(key, "is empty; give at least one number")
    return array


def _finite(key: str, array: np.ndarray) -> None:
    if not np.isfinite(array).all():
        at = int(np.argmin(np.isfinite(array)))
        raise argument(key, f"[{at}] is {array[at]}; give finite numbers, or leave the line out")


def whole(array: np.ndarray, dtype: Any = None) -> np.ndarray:
    """An array as the extension reads it: contiguous, aligned, of native byte order; copied only where the given one is not."""
    return np.require(
        array, array.dtype.newbyteorder("=") if dtype is None else dtype, ["C_CONTIGUOUS", "ALIGNED"]
    )


def own(array: np.ndarray) -> np.ndarray:
    """A copy that nobody can change: what a set was made of stays what it is, whatever its caller does with the arrays."""
    copy = np.array(array)
    copy.setflags(write=False)
    return copy


def real_array(key: str, given: Any) -> Real:
    """A contiguous array of finite real numbers; copied only where the given one is none."""
    array = _array(key, given)
    if array.dtype.kind == "c":
        raise argument(key, f"is complex ({array.dtype}); give real numbers")
    _finite(key, array)
    return whole(array, np.float64)


def complex_array(key: str, given: Any) -> Complex:
    """A contiguous array of finite complex numbers."""
    array = _array(key, given)
    if array.dtype.kind != "c":
        raise argument(key, f"is real ({array.dtype}); an FRF is complex: give real + 1j*imag")
    _finite(key, array)
    return whole(array, np.complex128)


def frequencies(key: str, given: Any, rising: bool = True) -> Real:
    """Frequencies (Hz), which must be finite and, where asked for, rise."""
    array = real_array(key, given)
    if rising and (array[1:] <= array[:-1]).any():
        at = int(np.argmax(array[1:] <= array[:-1])) + 1
        fault = "repeats" if array[at] == array[at - 1] else "does not follow"
        raise argument(
            key, f"[{at}] = {array[at]} {fault} {array[at - 1]}; sort the lines, and give each frequency once"
        )
    return array


def same_length(key: str, array: np.ndarray, of: str, wanted: int) -> None:
    """Refuses an array of another length than the one it belongs to."""
    if array.size != wanted:
        raise argument(key, f"has {array.size} entries, {of} has {wanted}; give arrays of equal length")


def name(key: str, given: Any) -> str:
    """A name, which must be text."""
    if not isinstance(given, str):
        raise argument(key, f"is {given!r} ({type(given).__name__}); give a name as text")
    if not given.strip():
        raise argument(key, "is empty; give a name")
    return given


def names(key: str, given: Any) -> list[str]:
    """A list of names; one name stands for itself."""
    if given is None:
        return []
    if isinstance(given, str):
        return [name(key, given)]
    if not isinstance(given, Iterable):
        raise argument(key, f"is {given!r}; give a list of names")
    return [name(f"{key}[{at}]", entry) for at, entry in enumerate(given)]


def optional_name(key: str, given: Any) -> str | None:
    """A name, or None."""
    return None if given is None else name(key, given)


def path(key: str, given: Any) -> str:
    """A path as text."""
    if not isinstance(given, (str, os.PathLike)):
        raise argument(key, f"is {given!r} ({type(given).__name__}); give a path")
    text = os.fspath(given)
    return text if isinstance(text, str) else os.fsdecode(text)


def number(key: str, given: Any, remedy: str = "give a finite number") -> float:
    """A finite real number."""
    if (
        isinstance(given, (bool, np.bool_))
        or not isinstance(given, (int, float, np.integer, np.floating))
        or not np.isfinite(given)
    ):
        raise argument(key, f"is {given!r}; {remedy}")
    return float(given)


def count(key: str, given: Any, least: int = 0) -> int:
    """A whole number from a least one."""
    if (
        isinstance(given, (bool, np.bool_))
        or not isinstance(given, (int, np.integer))
        or given < least
        or given >= 2**63
    ):
        raise argument(key, f"is {given!r}; give a whole number from {least}")
    return int(given)


def optional_count(key: str, given: Any, least: int = 0) -> int | None:
    """A whole number, or None."""
    return None if given is None else count(key, given, least)


def band(key: str, given: Any) -> tuple[float, float] | None:
    """Lowest and highest frequency (Hz), or None."""
    if given is None:
        return None
    ends = np.asarray(given, dtype=object)
    if ends.shape != (2,):
        raise argument(
            key, f"is {given!r}; give the lowest and the highest frequency in Hz, such as (20, 800)"
        )
    low, high = number(f"{key}[0]", ends[0]), number(f"{key}[1]", ends[1])
    if not 0 <= low < high:
        raise argument(
            key, f"is ({low}, {high}); give the lowest and the highest frequency in Hz, such as (20, 800)"
        )
    return low, high


def mapping(key: str, given: Any) -> dict[str, Any]:
    """A dictionary by name."""
    if not isinstance(given, Mapping):
        raise argument(key, f"is {type(given).__name__}; give a dictionary by name")
    return {name(f"{key}: a name", entry): value for entry, value in given.items()}


def optional_mapping(key: str, given: Any) -> dict[str, Any]:
    """A dictionary by name, which is empty for None."""
    return {} if given is None else mapping(key, given)


def unknown(key: str, given: Iterable[str], known: Iterable[str]) -> None:
    """Refuses names that are not known."""
    known = list(known)
    for entry in given:
        if entry not in known:
            raise argument(key, f"there is no «{entry}»; there are {', '.join(known)}")
