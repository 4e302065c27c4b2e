"""The command `jointid`, which runs inside the extension."""

from __future__ import annotations

import sys


def main() -> int:
    """Runs the command with the arguments of this process; returns its exit code."""
    from . import _core

    return _core.run_command(["jointid", *sys.argv[1:]])
