"""Refuses a processor that lacks the instructions the extension was built for, before the extension is loaded."""

from __future__ import annotations

import importlib.util
import platform
import subprocess
import sys
from pathlib import Path

# What x86-64-v3 has beyond x86-64, as Linux names it.
NEEDED = ("avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe")
# The extension carries this mark where it was built for x86-64-v3.
MARK = b"jointid-processor:" + b"x86-64-v3"
REMEDY = (
    'build it for this processor: RUSTFLAGS="-C target-cpu=x86-64" pip install --no-binary jointid jointid'
)


def flags() -> set[str] | None:
    """Instruction sets of this processor as Linux names them; None where they cannot be told."""
    if sys.platform == "linux":
        try:
            for line in Path("/proc/cpuinfo").read_text().splitlines():
                if line.startswith("flags"):
                    return set(line.partition(":")[2].split())
        except OSError:
            return None
    if sys.platform == "darwin":
        found = subprocess.run(
            ["sysctl", "-n", "machdep.cpu.leaf7_features"], capture_output=True, text=True, check=False
        )
        # A Mac with AVX2 has all of x86-64-v3.
        if found.returncode == 0:
            return set(NEEDED) if "AVX2" in found.stdout.split() else set()
    return None


def extension() -> Path | None:
    """File of the extension; None where it is not installed."""
    found = importlib.util.find_spec("jointid._core")
    return Path(found.origin) if found is not None and found.origin is not None else None


def check() -> None:
    """Raises ImportError where the processor lacks what the extension needs."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return
    has = flags()
    missing = [] if has is None else [name for name in NEEDED if name not in has]
    # Lesser processors are rare, and reading the file takes a while: only they pay for it.
    if missing and (file := extension()) is not None and MARK in file.read_bytes():
        raise ImportError(
            f"jointid was built for processors with AVX2 and FMA (x86-64-v3), and this one lacks {', '.join(missing)}; {REMEDY}"
        )
