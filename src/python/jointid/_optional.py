"""Packages that only some functions need."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from ._errors import needs


def optional(module: str, extra: str, purpose: str) -> Any:
    """An optional package.

    Raises
    ------
    ImportError
        It is not installed; the message says how to install it.
    """
    try:
        return import_module(module)
    except ImportError:
        raise needs(module, extra, purpose) from None


def pandas_for(purpose: str) -> Any:
    """The package pandas."""
    return optional("pandas", "pandas", purpose)
