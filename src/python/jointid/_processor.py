"""Loads the extension that was built for this processor.

A wheel for x86-64 holds the extension twice: for every such processor, and for those with AVX2 and FMA (x86-64-v3), which compute four frequencies in one
step. A build from source holds the one for the processor that its flags name.
"""

from __future__ import annotations

import importlib.util
import platform
import sys
from pathlib import Path

# What x86-64-v3 has beyond x86-64, as Linux names it.
NEEDED = ("avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe")
# The extension carries this mark where it was built for x86-64-v3.
MARK = b"jointid-processor:" + b"x86-64-v3"
REMEDY = (
    'build it for this processor: RUSTFLAGS="-C target-cpu=x86-64" pip install --no-binary jointid jointid'
)
# Folder of the extension for x86-64-v3, in wheels that hold both.
FAST = "x86_64_v3"
# Number of the feature AVX2 in Windows (PF_AVX2_INSTRUCTIONS_AVAILABLE).
_WINDOWS_AVX2 = 40


def flags() -> set[str] | None:
    """Instruction sets of this processor as Linux names them; None where they cannot be told."""
    if sys.platform == "linux":
        try:
            # Only the first processor is read: there may be hundreds.
            with open("/proc/cpuinfo", encoding="utf-8", errors="replace") as lines:
                for line in lines:
                    if line.startswith("flags"):
                        return set(line.partition(":")[2].split())
        except OSError:
            return None
    if sys.platform == "darwin":
        import subprocess

        found = subprocess.run(
            ["sysctl", "-n", "machdep.cpu.leaf7_features"], capture_output=True, text=True, check=False
        )
        # A Mac with AVX2 has all of x86-64-v3.
        if found.returncode == 0:
            return set(NEEDED) if "AVX2" in found.stdout.split() else set()
    if sys.platform == "win32":
        import ctypes

        # A processor with AVX2 has all of x86-64-v3.
        has = ctypes.windll.kernel32.IsProcessorFeaturePresent(_WINDOWS_AVX2)
        return set(NEEDED) if has else set()
    return None


def extension() -> Path | None:
    """File of the extension for every processor of the wheel; None where it is not installed."""
    found = importlib.util.find_spec("jointid._core")
    return Path(found.origin) if found is not None and found.origin is not None else None


def fast_extension() -> Path | None:
    """File of the extension for x86-64-v3, in wheels that hold both."""
    return next((Path(__file__).parent / FAST).glob("_core.*"), None)


def load() -> None:
    """Loads the extension for this processor as `jointid._core`.

    Raises
    ------
    ImportError
        The processor lacks what the only extension needs.
    """
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return
    has = flags()
    missing = [] if has is None else [name for name in NEEDED if name not in has]
    fast = fast_extension()
    if fast is not None and has is not None and not missing:
        spec = importlib.util.spec_from_file_location("jointid._core", fast)
        if spec is not None and spec.loader is not None:
            module = importlib.util.module_from_spec(spec)
            sys.modules["jointid._core"] = module
            spec.loader.exec_module(module)
            sys.modules["jointid"]._core = module  # type: ignore[attr-defined]
    # Lesser processors are rare, and reading the file takes a while: only they pay for it.
    elif missing and (file := extension()) is not None and MARK in file.read_bytes():
        raise ImportError(
            f"jointid was built for processors with AVX2 and FMA (x86-64-v3), and this one lacks {', '.join(missing)}; {REMEDY}"
        )
