"""Results are those of the command, and arrays those of files."""

from __future__ import annotations

import ast
import json
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import BENCH, LINES, NUTS, taps

import jointid as jd


def command(*words: str, folder=None) -> str:
    ran = subprocess.run(
        [sys.executable, "-m", "jointid", *words], capture_output=True, text=True, check=False, cwd=folder
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


def same(ours: dict, theirs: str) -> None:
    """Documents are equal, apart from what only a run on files knows."""
    other = json.loads(theirs)
    for document in (ours, other):
        document.pop("warnings", None)
    assert ours == other


def test_identification_is_that_of_the_command_bit_for_bit(found):
    same(json.loads(found.json), command("identify", "--positions", "l1,l3,l5", "--json"))
    assert found.parameters["k_n"].interval95 == found.interval95["k_n"]
    assert found.json == found.study.identify(progress=False, threads=1).json


def test_diagnosis_validation_comparison_plan_and_peaks_are_those_of_the_command(study, found, tmp_path):
    diagnosis = study.without("rotor-hold").diagnose(progress=False)
    arguments = ("diagnose", "--without", "rotor-hold", "--positions", "l1,l3,l5", "--no-cache", "--json")
    same(json.loads(diagnosis.json), command(*arguments))
    assert diagnosis.verdict.effects == ("rotor-hold",) or diagnosis.verdict.kind == "ambiguous"
    same(
        json.loads(study.compare(["l3"], progress=False).json),
        command("compare", "--positions", "l1,l3,l5", "--single", "l3", "--json"),
    )
    same(json.loads(study.plan(progress=False).json), command("plan", "--json"))
    found.save(tmp_path / "identification.json")
    validated = json.loads(command("validate", "--result", str(tmp_path / "identification.json"), "--json"))
    assert found.validate()["positions"] == validated["positions"]
    predicted = json.loads(
        command("predict", "--result", str(tmp_path / "identification.json"), "--nut-m", "0.5,0.9", "--json")
    )
    assert found.predict(nut_m=[0.5, 0.9], progress=False).positions == predicted["positions"]
    again = jd.Identification.load(tmp_path / "identification.json")
    assert again.json == found.json
    assert np.array_equal(again.frf(LINES, nut_m=0.6), found.frf(LINES, nut_m=0.6))


def test_frfs_are_those_of_the_command(tmp_path):
    arguments = (
        "--from-hz",
        "10",
        "--to-hz",
        "400",
        "--step-hz",
        "2",
        "--response",
        "table",
        "--excitation",
        "table",
        "--position",
        "l1,l5",
        "--json",
    )
    printed = json.loads(command("simulate", "frf", *arguments))
    theirs = np.array([printed["positions"][name] for name in ("l1", "l5")])
    ours = jd.Study().frf(printed["frequency_hz"], positions=["l1", "l5"], **BENCH)
    assert np.array_equal(ours, theirs[..., 0] + 1j * theirs[..., 1])
    assert jd.Study().frf([100.0], positions="l5", **BENCH).shape == (1,)


def test_arrays_are_what_files_are(on_frfs, tmp_path):
    on_frfs.study.measurements.save(tmp_path / "set")
    of_files = jd.Study(None, tmp_path / "set").choose_fit(["p1", "p3"]).identify(progress=False)
    assert of_files.parameters == on_frfs.parameters and of_files.cost == on_frfs.cost
    low, high = on_frfs.interval95["k_n"]
    assert low < 4e8 < high
    with pytest.raises(jd.InputError, match=r"manifest\.toml: already exists"):
        on_frfs.study.measurements.save(tmp_path / "set")
    printed = command("identify", "--measurements", "set", "--positions", "p1,p3", "--json", folder=tmp_path)
    assert json.loads(printed)["cost"] == on_frfs.cost


def test_universal_files_come_back(tmp_path):
    ours = taps(5e8, 3)
    assert ours.to_uff(tmp_path / "taps.uff")
    with pytest.raises(jd.InputError, match=r"taps\.uff: already exists"):
        ours.to_uff(tmp_path / "taps.uff")
    assert ours.to_uff(tmp_path / "taps.uff", replace=True)
    read = jd.read_uff(tmp_path / "taps.uff", pattern="position {}", nut_m=NUTS)
    assert list(read.frfs) == list(ours.frfs)
    for name, frf in read.frfs.items():
        assert np.allclose(frf.value, ours.frfs[name].value, rtol=1e-12)
        assert np.array_equal(frf.frequency_hz, LINES)


def test_peaks_and_stabilisation_find_the_modes():
    lines = np.linspace(5.0, 400.0, 800)
    peaks = jd.peaks(taps(5e8, 2, 0.003, lines))
    elastic = [mode["frequency_hz"] for mode in peaks["modes"] if mode["regular"]]
    assert elastic and peaks.to_frame()["damping_ratio"].between(0, 1).all()
    poles = peaks.stabilisation("p1", max_order=24)
    stable = poles[poles["stable"]]["frequency_hz"]
    assert all(np.abs(stable / frequency - 1).min() < 0.03 for frequency in elastic)
    assert peaks.modes_csv.startswith("position,order,")


@pytest.mark.parametrize(
    "what", ["machine", "set", "files", "study", "found", "on_frfs", "diagnosis", "peaks", "error"]
)
def test_objects_pickle(what, study, found, on_frfs):
    made = {
        "machine": lambda: study.machine,
        "set": lambda: on_frfs.study.measurements,
        "files": lambda: study.measurements,
        "study": lambda: on_frfs.study.without("rotor-hold").with_settings(freeze=["k_m"]),
        "found": lambda: found,
        "on_frfs": lambda: on_frfs,
        "diagnosis": lambda: jd.Diagnosis(json.dumps({"verdict": {}}), study),
        "peaks": lambda: jd.peaks(on_frfs.study.measurements),
        "error": lambda: jd.InputError("axis.toml, line 3: no", "axis.toml", 3, "k"),
    }[what]()
    again = pickle.loads(pickle.dumps(made))
    assert type(again) is type(made)
    if what == "machine":
        assert (again.text, again.path) == (made.text, made.path)
    elif what in ("found", "on_frfs"):
        assert again.json == made.json
        assert np.array_equal(again.frf(LINES, nut_m=0.9), made.frf(LINES, nut_m=0.9))
    elif what == "study":
        assert (again._state.fit, again._state.settings) == (made._state.fit, made._state.settings)
        assert again.parameters == made.parameters
    elif what in ("set", "files"):
        assert again._files() == made._files() and again.path == made.path
    elif what == "error":
        assert (again.file, again.line, again.key) == ("axis.toml", 3, "k")
    else:
        assert again.json == made.json


def test_a_profile_has_its_minimum_at_the_estimate(on_frfs):
    value, (low, high) = on_frfs.parameters["k_n"].value, on_frfs.interval95["k_n"]
    values, costs = on_frfs.profile("k_n", [low, value, high])
    assert list(values) == [low, value, high]
    assert abs(costs[1] - on_frfs.cost) < 0.1
    # χ² at the ends of a 95 % interval of one parameter lies 3.84 above the minimum.
    assert np.allclose(costs[[0, 2]] - costs[1], 3.84, rtol=0.3)


def test_the_named_effect_is_applied():
    diagnosis = (
        jd.Study()
        .choose_fit(["l1", "l3", "l5"])
        .without("rotor-hold")
        .diagnose(progress=False, effects=["rotor-hold"])
    )
    if diagnosis.verdict.kind == "effect":
        assert "k_s" in diagnosis.apply().parameters
    else:
        with pytest.raises(jd.InputError, match="names no single effect"):
            diagnosis.apply()


def test_matlab_files_hold_the_document(found, tmp_path):
    scipy_io = pytest.importorskip("scipy.io")
    scipy_io.savemat(tmp_path / "own.mat", {"own": 1.0})
    with pytest.raises(jd.InputError, match=r"own\.mat: already exists"):
        found.to_mat(tmp_path / "own.mat")
    for _ in range(2):
        found.to_mat(tmp_path / "found.mat")
    read = scipy_io.loadmat(tmp_path / "found.mat", simplify_cells=True)["identification"]
    assert read["parameters"]["k_n"]["value"] == found.parameters["k_n"].value
    assert list(read["parameters"]["k_n"]["interval95"]) == list(found.interval95["k_n"])
    assert read["fit_positions"].tolist() == ["l1", "l3", "l5"]
    assert read["positions"]["l1"]["orders"][0]["measured_hz"] == 24
    with pytest.raises(jd.InputError, match=r"\.mat"):
        found.to_mat(tmp_path / "found.txt")


def test_figures_show_what_they_say(found, on_frfs, tmp_path):
    pytest.importorskip("matplotlib").use("Agg")
    diagnosis = on_frfs.study.without("rotor-hold").diagnose(
        progress=False, effects=["rotor-hold", "bed-compliance"]
    )
    lines = np.linspace(5.0, 400.0, 500)
    figures = {
        "modes-before-after": found.plot(),
        "frfs": on_frfs.plot(),
        "profile": on_frfs.plot_profile("k_n", 3),
        "shapes": on_frfs.plot_modes(nut_m=0.9),
        "prediction": on_frfs.predict(nut_m=[0.4, 0.9, 1.4], progress=False).plot(),
        "diagnosis": diagnosis.plot(),
        "stabilisation": jd.peaks(taps(5e8, 2, 0.003, lines)).plot(),
    }
    for name, figure in figures.items():
        figure.savefig(tmp_path / f"{name}.png")
        drawn = [axis for axis in figure.axes if axis.lines or axis.patches or axis.collections]
        assert drawn, name
    magnitude = figures["frfs"].axes[0]
    measured, _, after = magnitude.lines
    assert np.abs(np.log(measured.get_ydata() / after.get_ydata())).mean() < 0.05


def test_tables_of_pandas(found, on_frfs):
    pandas = pytest.importorskip("pandas")
    frame = found.to_frame()
    assert frame.equals(found.parameters.to_frame())
    assert isinstance(frame, pandas.DataFrame) and frame.loc["k_n", "value"] == found.parameters["k_n"].value
    assert list(on_frfs.predict(nut_m=0.9, progress=False).to_frame()["order"])[:2] == [1, 2]


def test_the_stubs_are_the_extension():
    """The stub file of the extension names what is there, and nothing else."""
    from jointid import _core

    def public(names):
        return {name for name in names if not name.startswith("_")}

    tree = ast.parse((Path(jd.__file__).parent / "_core.pyi").read_text(encoding="utf-8"))
    stubs: dict[str, set[str]] = {}
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            of_class = {entry.name for entry in node.body if isinstance(entry, ast.FunctionDef)}
            of_class |= {entry.target.id for entry in node.body if isinstance(entry, ast.AnnAssign)}
            stubs[node.name] = public(of_class)
        elif isinstance(node, ast.FunctionDef):
            stubs[node.name] = set()
    assert public(dir(_core)) == set(stubs)
    for name, members in stubs.items():
        if members:
            assert public(vars(getattr(_core, name))) == members, name


def reused() -> jd.MeasurementSet:
    """A set of arrays that are overwritten after it is made, as a loop over machines does."""
    of = taps(4e8, 1)
    names = list(of.nut_m)
    lines, relative_sd = LINES.copy(), np.full(LINES.size, 0.01)
    values = {name: of.frfs[name].value.copy() for name in names}
    made = jd.MeasurementSet.from_arrays(
        lines, values, relative_sd=dict.fromkeys(names, relative_sd), nut_m=NUTS, **BENCH
    )
    for array in (lines, relative_sd, *values.values()):
        array[:] = 1.0
    return made


def test_a_set_stays_as_it_was_made(tmp_path):
    whole, made = taps(4e8, 1), reused()
    made.save(tmp_path / "set")
    for copy in (made, pickle.loads(pickle.dumps(made)), jd.MeasurementSet(tmp_path / "set")):
        for name, frf in copy.frfs.items():
            assert np.array_equal(frf.value, whole.frfs[name].value), name
            assert np.array_equal(frf.frequency_hz, LINES)


def test_arrays_of_any_kind_are_the_same_set():
    value = taps(4e8, 1).frfs["p1"].value
    both = np.stack([value, value])
    backwards, fixed = value[::-1].copy()[::-1], value.copy()
    fixed.setflags(write=False)
    kinds = [
        both[0],
        np.asfortranarray(np.stack([value, value], axis=1))[:, 0],
        backwards,
        value.astype(">c16"),
        fixed,
        np.ma.masked_array(value),
        value.view(type("Own", (np.ndarray,), {})),
    ]
    for kind in kinds:
        frf = jd.MeasurementSet.from_arrays(LINES, {"p1": kind}, nut_m={"p1": 0.6}, **BENCH).frfs["p1"]
        assert np.array_equal(frf.value, value)


def test_masked_and_empty_lines_are_said():
    value = taps(4e8, 1).frfs["p1"].value
    with pytest.raises(jd.InputError, match="2 masked entries"):
        masked = np.ma.masked_array(value, mask=np.arange(value.size) < 2)
        jd.MeasurementSet.from_arrays(LINES, {"p1": masked}, **BENCH)
    empty = np.where(np.arange(value.size) < 3, 0, value)
    made = jd.MeasurementSet.from_arrays(LINES, {"p1": empty}, nut_m={"p1": 0.6}, **BENCH)
    assert any("3 of 150 lines are not used" in warning for warning in made.warnings)
    assert made.frfs["p1"].value.size == value.size - 3
    with pytest.raises(jd.InputError, match="coherence"):
        jd.MeasurementSet.from_arrays(LINES, {"p1": value}, coherence=np.ones(LINES.size), **BENCH)


def test_draws_name_their_minimum(on_frfs, found, study):
    for identified, count in ((on_frfs, 7), (found, 5)):
        drawn = identified.draws(count, bootstrap=False)
        minima = max(1, len(identified.document.get("basins", ())))
        assert list(np.bincount(drawn.minimum)) == [count] * minima
        assert drawn.values.shape == (count * minima, len(drawn.parameters))
        assert (drawn.weight[drawn.minimum == 0] == 1).all() and (drawn.weight <= 1).all()
        table = drawn.to_frame()
        assert list(table.columns) == ["minimum", "weight", *drawn.parameters]
    assert study.plan(progress=False).best
