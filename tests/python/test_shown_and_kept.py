"""What results show in notebooks and figures, how they are kept, and what a machine does without measurements."""

from __future__ import annotations

import json

import numpy as np
import pytest
from conftest import BENCH, LINES, NUTS, taps

import jointid as jd


@pytest.mark.parametrize("made_of", ["arrays", "universal file", "tables", "files"])
def test_an_identification_is_loaded_with_its_set(made_of, tmp_path):
    own = taps(4e8, 1)
    if made_of == "universal file":
        own.to_uff(tmp_path / "own.uff")
        own = jd.read_uff(tmp_path / "own.uff", pattern="position {}", nut_m=NUTS, **BENCH)
        assert own.warnings == []
    elif made_of == "tables":
        own.save(tmp_path / "tables")
        files = {name: tmp_path / f"tap-{name}.csv" for name in NUTS}
        for at, file in enumerate(files.values()):
            file.write_bytes((tmp_path / f"tables/frf/{at + 1}.csv").read_bytes())
        own = jd.read_tables(list(files.values()), pattern="tap-{}", nut_m=NUTS, **BENCH)
    elif made_of == "files":
        own = jd.MeasurementSet.from_files(own._files())
    found = jd.Study(None, own).choose_fit(["p1", "p3"]).identify(progress=False, tolerances=False)
    found.save(tmp_path / "found.json")
    again = jd.Identification.load(tmp_path / "found.json")
    assert again.json == found.json
    assert np.array_equal(again.frf(LINES, nut_m=0.9), found.frf(LINES, nut_m=0.9))
    assert again.validate()["positions"] == found.validate()["positions"]
    found.save(tmp_path / "found.json")
    assert found.report(tmp_path / "page.html") == []
    # Without the folder beside it the set is asked for, and may be given.
    moved = tmp_path / "moved.json"
    (tmp_path / "found.json").rename(moved)
    if made_of != "universal file":
        with pytest.raises(jd.InputError, match=r"measurements=…") as refused:
            jd.Identification.load(moved)
        assert refused.value.key == "measurements"
    assert jd.Identification.load(moved, measurements=own).json == found.json


def test_notebooks_show_parameters_gap_chi_square_and_warnings():
    in_mm = taps(4e8, 1)
    wrong = jd.MeasurementSet.from_arrays(
        LINES, {name: 1e3 * frf.value for name, frf in in_mm.frfs.items()}, nut_m=NUTS, **BENCH
    )
    found = jd.Study(None, wrong).choose_fit(["p1", "p3"]).identify(progress=False)
    shown = found._repr_html_()
    assert found.warnings and all(text in shown for text in ("k_n", "χ²", "gap", "warning"))
    assert "χ²" in repr(found) and repr(found).count("warning:") == len(found.warnings)
    for made in (wrong, found.study, found.study.machine, found.validate(), found.parameters):
        assert made._repr_html_().count("<table>") >= 1
    assert "p1 at 0.6 m" in wrong._repr_html_()


def test_a_machine_computes_without_measurements():
    machine, study = jd.Machine("configs/tian.toml"), jd.Study()
    ours = machine.frf(LINES, nut_m=[0.6, 1.2], response="table", excitation="table")
    assert np.array_equal(ours, study.frf(LINES, nut_m=[0.6, 1.2], **BENCH))
    assert machine.frf(LINES, response="table", excitation="table").shape == LINES.shape
    modes = machine.modes(nut_m=0.9)
    assert np.array_equal(modes.frequency_hz, study.modes(nut_m=0.9).frequency_hz)
    assert np.allclose(modes.mac().diagonal(), 1.0) and set(modes.units.values()) == {"m", "rad"}
    # The receptance falls to the static compliance towards 0 Hz.
    still = machine.frf([1e-3], nut_m=0.6, response="table", excitation="table")[0]
    assert np.isclose(1 / abs(still), machine.static_stiffness("table", nut_m=0.6), rtol=1e-3)
    motion = jd.Machine("configs/emps.toml").simulate_motion(travel_m=0.05, progress=False)
    assert motion.is_stable and np.isclose(np.ptp(motion["command_m"]), 0.05)
    for call, key in (
        (lambda: machine.simulate_motion(sine=(1, 2)), "sine"),  # type: ignore[typeddict-item]
        (lambda: machine.simulate_motion(speed=3), "motion"),  # type: ignore[call-arg]
        (lambda: machine.static_stiffness("tabel"), None),
        (lambda: machine.modes(nut_m=99), "nut_m"),
    ):
        with pytest.raises(jd.InputError) as refused:
            call()
        assert key is None or refused.value.key == key


def test_figures_draw_into_given_axes(found, on_frfs):
    plt = pytest.importorskip("matplotlib.pyplot")
    plt.switch_backend("Agg")
    figure, axes = plt.subplots(6, 2)
    assert on_frfs.plot(ax=axes[:3]) is figure and axes[0, 0].lines and not axes[3, 0].lines
    with pytest.raises(jd.InputError, match="6 panels") as refused:
        on_frfs.plot(ax=axes[0, 0])
    assert refused.value.key == "ax"
    many = jd.MeasurementSet.from_arrays(
        LINES,
        {f"p{at}": taps(4e8, 1).frfs["p1"].value for at in range(9)},
        nut_m={f"p{at}": 0.6 + 0.1 * at for at in range(9)},
        **BENCH,
    )
    drawn = jd.Study(None, many).choose_fit(["p0", "p8"]).identify(progress=False, tolerances=False).plot()
    assert len(drawn.axes) == 18
    units = [axis.get_ylabel() for axis in found.plot_modes(nut_m=0.9, max_hz=300).axes]
    assert units.count("displacement") == units.count("angle") == 1
    plt.close("all")


def test_tables_go_in_and_out(on_frfs):
    pandas = pytest.importorskip("pandas")
    own = on_frfs.study.measurements
    table = own.to_frame()
    again = jd.MeasurementSet.from_frame(table, nut_m=own.nut_m)
    assert again.to_frame().equals(table)
    parts = table.assign(real=table["value"].to_numpy().real, imag=table["value"].to_numpy().imag)
    assert jd.MeasurementSet.from_frame(parts.drop(columns="value"), nut_m=own.nut_m).to_frame().equals(table)
    for wrong, words in (
        (table.rename(columns={"value": "H"}), "«H»"),
        (table.drop(columns="value"), "real and imag"),
        ([1], "DataFrame"),
    ):
        with pytest.raises(jd.InputError, match=words):
            jd.MeasurementSet.from_frame(wrong)
    assert isinstance(table, pandas.DataFrame)


def test_predictions_and_draws_go_to_other_libraries(on_frfs):
    predicted = on_frfs.predict(nut_m=[0.7, 0.9], frequency_hz=[50.0, 100.0], draws=39, progress=False)
    assert set(predicted.bands) == {"0.7", "0.9"}
    pytest.importorskip("xarray")
    dataset = predicted.to_xarray()
    assert np.array_equal(dataset["frf"].sel(position="0.9"), predicted.bands["0.9"].value)
    assert dataset["frequency_hz"].dims == ("position", "order")
    pytest.importorskip("arviz")
    draws = on_frfs.draws(5)
    inference = draws.to_arviz()
    assert inference.posterior["k_n"].shape == (draws.minimum.max() + 1, 5)


def test_results_replace_on_request(found, tmp_path):
    (tmp_path / "own.json").write_text("{}")
    with pytest.raises(jd.InputError, match="already exists"):
        found.save(tmp_path / "own.json")
    found.save(tmp_path / "own.json", replace=True)
    assert json.loads((tmp_path / "own.json").read_text()) == found.document
    own = taps(4e8, 1)
    own.save(tmp_path / "set")
    own.save(tmp_path / "set", replace=True)
