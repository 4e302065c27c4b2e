"""Every bad argument is an InputError that names it and says what to give; nothing is written."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
import traceback
from pathlib import Path

import numpy as np
import pytest
from conftest import BENCH, LINES, taps

import jointid as jd

ONES = np.ones(3, complex)
THREE = np.array([1.0, 2.0, 3.0])


def arrays(frequency_hz=THREE, frfs=None, **changed):
    return jd.MeasurementSet.from_arrays(
        frequency_hz, {"p": ONES} if frfs is None else frfs, **(BENCH | changed)
    )


ARRAYS = [
    ("frfs['p']", "has 2 entries", lambda: arrays(frfs={"p": ONES[:2]})),
    ("frequency_hz", "does not follow", lambda: arrays([1.0, 3.0, 2.0])),
    ("frequency_hz", "repeats", lambda: arrays([1.0, 2.0, 2.0])),
    ("frfs['p']", "real + 1j", lambda: arrays(frfs={"p": ONES.real})),
    ("frfs['p']", "[1] is (nan", lambda: arrays(frfs={"p": np.array([1, np.nan, 1]) + 0j})),
    ("frequency_hz", "[0] is inf", lambda: arrays([np.inf, 2, 3])),
    ("frfs['p']", "has the type <U1", lambda: arrays(frfs={"p": np.array(["a", "b", "c"])})),
    ("frfs['p']", "Python objects", lambda: arrays(frfs={"p": np.array([1j, None, 2], dtype=object)})),
    ("frfs['p']", "shape (3, 1)", lambda: arrays(frfs={"p": ONES[:, None]})),
    ("frequency_hz", "is complex", lambda: arrays(ONES)),
    ("frequency_hz", "is missing", lambda: arrays(None)),
    ("frequency_hz", "is empty", lambda: arrays([])),
    ("frfs", "holds nothing", lambda: arrays(frfs={})),
    ("frfs: a name", "give a name as text", lambda: arrays(frfs={3: ONES})),
    ("frfs: a name", "is empty", lambda: arrays(frfs={" ": ONES})),
    ("frfs[0]", "has no value", lambda: arrays(frfs=[{"frequency_hz": THREE}])),
    ("frfs[0]", "there is no «frequency»", lambda: arrays(frfs=[{"frequency": THREE, "value": ONES}])),
    ("frfs[0]", "give a dictionary", lambda: arrays(frfs=[ONES])),
    ("coherence", "there is no «q»", lambda: arrays(coherence={"q": THREE}, averages=8)),
    ("coherence['p']", "has 2 entries", lambda: arrays(coherence={"p": [0.9, 0.9]}, averages=8)),
    ("averages", "says nothing", lambda: arrays(coherence={"p": [0.9, 0.9, 0.9]})),
    ("averages", "whole number from 1", lambda: arrays(averages=0)),
    ("averages", "whole number from 1", lambda: arrays(averages=True)),
    ("quantity", "is missing", lambda: arrays(quantity=None)),
    ("quantity", "accelerance", lambda: arrays(quantity="acceleration")),
    ("response", "is missing", lambda: arrays(response=None)),
    ("gain", "unknown", lambda: arrays(gain="free")),
    ("gain", "above 0", lambda: arrays(gain=-1.0)),
    ("nut_m['p']", "give a distance", lambda: arrays(nut_m={"p": "left"})),
    ("nut_m['p']", "give a distance", lambda: arrays(nut_m={"p": float("nan")})),
    ("motions['r']", "time_s", lambda: arrays(frfs={}, motions={"r": {"time_s": THREE}})),
]


def is_short(refused: pytest.ExceptionInfo[jd.InputError]) -> bool:
    """Whether a traceback has at most ten lines, of which the caller's are three."""
    package = str(Path(jd.__file__).parent)
    ours = [frame for frame in refused.traceback if str(frame.path).startswith(package)]
    shown = "".join(traceback.format_list(traceback.extract_tb(refused.tb)[-len(ours) :]))
    return len(f"Traceback\n1\n2\n3\n{shown}{refused.value}".splitlines()) <= 10


@pytest.mark.parametrize(("key", "words", "call"), ARRAYS, ids=[f"{key} {words}" for key, words, _ in ARRAYS])
def test_arrays_are_refused_by_name(key, words, call):
    with pytest.raises(jd.InputError) as refused:
        call()
    assert refused.value.key == key
    assert words in str(refused.value)
    assert is_short(refused)


CALLS = [
    ("seed", "whole number", lambda study: study.identify(seed=-1)),
    ("foo", "is no setting", lambda study: study.identify(foo=1)),
    ("objective", "write one of", lambda study: study.identify(objective="chi2")),
    ("band_hz", "lowest and the highest", lambda study: study.identify(band_hz=(300, 20))),
    ("band_hz", "lowest and the highest", lambda study: study.identify(band_hz=[1])),
    ("tolerances", "True or False", lambda study: study.identify(tolerances="none")),
    ("bootstrap", "at least 50", lambda study: study.identify(bootstrap=3)),
    ("freeze", "no such parameter", lambda study: study.identify(freeze="k_x")),
    ("threads", "whole number from 1", lambda study: study.identify(threads=0)),
    ("progress", "True, False", lambda study: study.identify(progress=3)),
    ("without", "does not contain", lambda study: study.without("backlash")),
    ("overrides", "there is no key", lambda study: study.overridden({"parameter.k_x.start": 1.0})),
    ("names[0]", "give a name", lambda study: study.choose_fit([1])),
    ("nut_m", "outside the screw", lambda study: study.frf(THREE, nut_m=99.0, **BENCH)),
    ("nut_m", "named twice", lambda study: study.frf(THREE, nut_m=[0.5, 0.5], **BENCH)),
    ("nut_m", "beside positions", lambda study: study.frf(THREE, nut_m=0.5, positions="l1", **BENCH)),
    ("frequency_hz", "above 0", lambda study: study.frf([0.0, 1.0], nut_m=0.5, **BENCH)),
    ("response", "no such point", lambda study: study.frf(THREE, nut_m=0.5, response="tabel")),
    ("data", "modes or frf", lambda study: study.plan(data="uff", progress=False)),
    ("ablate", "in-sample", lambda study: study.diagnose(ablate="all", progress=False)),
    ("nulls", "20 to 2000", lambda study: study.diagnose(nulls=2, progress=False)),
]


@pytest.mark.parametrize(("key", "words", "call"), CALLS, ids=[f"{key} {words}" for key, words, _ in CALLS])
def test_arguments_are_refused_by_name(key, words, call, study):
    with pytest.raises(jd.InputError) as refused:
        call(study)
    assert refused.value.key == key
    assert words in str(refused.value)
    assert is_short(refused)


def test_files_are_refused_with_file_line_and_key(tmp_path):
    with pytest.raises(jd.InputError) as refused:
        jd.Study(tmp_path / "none.toml")
    assert refused.value.file == str(tmp_path / "none.toml")
    (tmp_path / "axis.toml").write_text('title = "axis"\nx = [\n')
    with pytest.raises(jd.InputError) as refused:
        jd.Machine(tmp_path / "axis.toml")
    assert refused.value.file == str(tmp_path / "axis.toml") and refused.value.line is not None
    taps(5e8, 1).save(tmp_path / "set")
    table = tmp_path / "set/frf/1.csv"
    table.write_text(table.read_text().replace("\n", "\nx,1,2\n", 1))
    with pytest.raises(jd.InputError) as refused:
        jd.MeasurementSet(tmp_path / "set")
    assert (refused.value.file, refused.value.line) == (str(table), 2)
    with pytest.raises(jd.InputError, match="no FRF|no such file"):
        jd.read_uff(tmp_path / "none.uff")
    with pytest.raises(jd.InputError, match="no identification"):
        jd.Identification.load(tmp_path / "axis.toml")


def test_nothing_is_written_where_writing_fails(tmp_path, found):
    (tmp_path / "file").write_text("")
    with pytest.raises(jd.InputError, match="is a file; name a folder"):
        found.save(tmp_path / "file" / "identification.json")
    with pytest.raises(jd.InputError, match="cannot be written"):
        jd.Fleet(tmp_path / "file", None, {"m": "measurements/tian"})
    (tmp_path / "own.json").write_text("{}")
    (tmp_path / "link.json").symlink_to(tmp_path / "nowhere")
    for name, fault in (("own.json", "already exists"), ("link.json", "is a link")):
        with pytest.raises(jd.InputError, match=fault):
            found.save(tmp_path / name)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["file", "link.json", "own.json"]
    found.save(tmp_path / "found.json")
    found.save(tmp_path / "found.json")


def test_odd_arrays_are_read_as_they_are():
    values = jd.Study().frf(LINES, nut_m=0.6, **BENCH)
    values.flags.writeable = False
    every_second = arrays(LINES[::2], {"p": values[::2]}, nut_m={"p": 0.6})
    assert np.array_equal(every_second.frfs["p"].value, values[::2])
    reverse_bytes = arrays(LINES.astype(">f8"), {"p": values.astype(">c16")}, nut_m={"p": 0.6})
    assert np.array_equal(reverse_bytes.frfs["p"].value, values)
    buffer = np.frombuffer(b"x" + values.tobytes(), dtype=np.uint8)[1:].view(np.complex128)
    assert not buffer.flags.aligned
    unaligned = arrays(LINES, {"p": buffer}, nut_m={"p": 0.6})
    assert np.array_equal(unaligned.frfs["p"].value, values)
    single = arrays(
        LINES.astype(np.float32).astype(float), {"p": values.astype(np.complex64)}, nut_m={"p": 0.6}
    )
    assert single.frfs["p"].value.dtype == np.complex128
    listed = arrays(
        LINES.tolist(), [{"position": "p", "frequency_hz": LINES, "value": list(values)}], nut_m={"p": 0.6}
    )
    assert np.array_equal(listed.frfs["p"].value, values)


@pytest.mark.parametrize("work", ["identify", "diagnose", "peaks"])
def test_an_interrupt_ends_a_call(work, study):
    many = taps(5e8, 2, 0.003, np.linspace(5.0, 400.0, 4000)) if work == "peaks" else None
    # As in a terminal: a process in the background begins with interrupts ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    long = {
        "identify": lambda: study.identify(bootstrap=5000, progress=False),
        "diagnose": lambda: study.diagnose(nulls=2000, progress=False),
        "peaks": lambda: jd.peaks(many, max_order=120, progress=False),
    }[work]

    # Processor time, which other programs do not lengthen; the whole work takes far more of it.
    begun: list[float] = []

    def interrupt():
        time.sleep(0.4)
        begun.append(time.process_time())
        signal.raise_signal(signal.SIGINT)

    threading.Thread(target=interrupt).start()
    try:
        with pytest.raises(KeyboardInterrupt):
            long()
        assert time.process_time() - begun[0] < (os.cpu_count() or 1) * 1.0
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_callback_sees_the_progress_and_may_end_the_work(study):
    seen = []
    study.identify(bootstrap=50, progress=lambda *state: seen.append(state))
    assert ("bootstrap", 50, 50) in seen
    with pytest.raises(ZeroDivisionError):
        study.identify(bootstrap=5000, progress=lambda *_: 1 / 0)


def counted_during(work) -> int:
    """Times that this thread ran while another one did some work."""
    counted = 0
    worker = threading.Thread(target=work)
    worker.start()
    while worker.is_alive():
        counted += 1
        time.sleep(0.001)
    return counted


def test_other_threads_run_meanwhile(study):
    assert counted_during(lambda: study.identify(bootstrap=50, progress=False)) > 20


def test_other_threads_run_while_a_set_is_made():
    lines = np.arange(1.0, 400_001.0)
    value = np.exp(1j * lines)
    assert counted_during(lambda: arrays(lines, {"p": value}, nut_m={"p": 0.6})) > 3


LESSER = """
import importlib.util, sys
from pathlib import Path

folder = Path(importlib.util.find_spec("jointid").origin).parent
spec = importlib.util.spec_from_file_location("jointid._processor", folder / "_processor.py")
sys.modules[spec.name] = processor = importlib.util.module_from_spec(spec)
spec.loader.exec_module(processor)
processor.flags, processor.platform.machine = lambda: set(sys.argv[1:]), lambda: "x86_64"
import jointid as jd

print(Path(jd._core.__file__).parent.name)
assert len(jd.Machine("configs/tian.toml").modes(nut_m=0.9).frequency_hz) > 3
"""


def test_the_extension_is_that_of_the_processor():
    from jointid import _processor

    package = Path(_processor.__file__).parent
    (every,) = (file for file in package.glob("_core.*") if file.suffix in (".so", ".pyd"))

    def imported(*flags):
        return subprocess.run([sys.executable, "-c", LESSER, *flags], capture_output=True, text=True, check=False)

    lesser = imported("sse2", "avx")
    if _processor.MARK in every.read_bytes():
        # A build from source for x86-64-v3: refused before the extension loads, which would end the process.
        assert lesser.returncode == 1 and "lacks avx2" in lesser.stderr and "RUSTFLAGS" in lesser.stderr
        assert len(lesser.stderr.splitlines()) <= 10
    else:
        assert (lesser.returncode, lesser.stdout.strip()) == (0, "jointid"), lesser.stderr
    fast = _processor.fast_extension()
    if fast is not None and _processor.flags() >= set(_processor.NEEDED):
        assert _processor.MARK in fast.read_bytes()
        newer = imported(*_processor.NEEDED)
        assert (newer.returncode, newer.stdout.strip()) == (0, _processor.FAST), newer.stderr
