//! Parameters recovered from the data of an independent model: finite elements with consistent mass, from the
//! default start values.

use std::fmt::Write as _;
use std::path::Path;

use dynamics::model::RodModel;
use identification::objective::{Deviation, ModeObjective, ModeSettings, ModeSquares, PositionPrediction};
use identification::{Identification, IdentificationSettings, Place, identify};
use long_work::Control;
use machine::Machine;
use measurement::{MeasurementSet, read_set};
use numeric::statistics::median;
use optimizer::LeastSquares;

use crate::support::bench_equations::Joints;
use crate::support::everything::everything;
use crate::support::finite_elements::{Bench, Peak};
use crate::support::{Draws, POSITIONS, config};

const TRUTH: Joints = Joints {
    k_al: 4.1e7,
    k_ar: 2.7e7,
    k_n: 7.9e8,
    k_m: 399.0,
    c_al: 30.0,
    c_ar: 30.0,
    c_n: 4.2e4,
    c_m: 0.045,
};
const GAIN: f64 = 0.3;

/// Returns peaks of the finite-element bench at l1, l3, l5, with the rotor hold of the configuration.
fn peaks_of(truth: Joints) -> Vec<Vec<Peak>> {
    [0.6, 1.0, 1.6].iter().map(|nut| Bench::new(60, *nut, truth, (1e6, 1.0)).peaks(12.0, 950.0)).collect()
}

/// Writes a measurement set to disk, in a user's form, and reads it.
fn write_set(
    folder: &Path,
    peaks: &[Vec<Peak>],
    resolution: Option<f64>,
    scatter: &mut dyn FnMut() -> f64,
) -> MeasurementSet {
    let mut manifest = String::from(
        "title = \"finite elements\"\nquantity = \"mobility\"\ngain = \"unknown\"\nresponse = \"table\"\nexcitation = \"table\"\nmodes = \"modes.csv\"\n",
    );
    if let Some(step) = resolution {
        let _ = writeln!(manifest, "frequency_resolution_hz = {step:?}");
    }
    manifest += "[split]\nfit = [\"l1\", \"l3\", \"l5\"]\n";
    let mut modes = String::from("position,order,frequency_hz,amplitude\n");
    for (at, (name, nut)) in [POSITIONS[0], POSITIONS[2], POSITIONS[4]].iter().enumerate() {
        let _ = writeln!(manifest, "[[position]]\nname = \"{name}\"\nnut_m = {nut:?}");
        for (order, peak) in peaks[at].iter().enumerate() {
            let frequency = resolution.map_or(peak.frequency_hz, |s| (peak.frequency_hz / s).round() * s);
            let amplitude = GAIN * peak.amplitude * scatter();
            let _ = writeln!(modes, "{name},{},{frequency:.9},{amplitude:.9e}", order + 1);
        }
    }
    std::fs::write(folder.join("manifest.toml"), manifest).unwrap();
    std::fs::write(folder.join("modes.csv"), modes).unwrap();
    read_set(&folder.display().to_string()).unwrap()
}

fn run(machine: &Machine, set: &MeasurementSet, plan: &IdentificationSettings) -> Identification {
    let (fit, held_out) = set.split(None, &[]).unwrap();
    identify(machine, &fit, &held_out, plan, &Control::default()).unwrap()
}

fn error(machine: &Machine, found: &Identification, id: &str, truth: f64) -> f64 {
    found.values[machine.parameter(id).unwrap()] / truth - 1.0
}

const IDENTIFIABLE: [(&str, f64); 6] = [
    ("k_al", TRUTH.k_al),
    ("k_ar", TRUTH.k_ar),
    ("k_n", TRUTH.k_n),
    ("k_m", TRUTH.k_m),
    ("c_n", TRUTH.c_n),
    ("c_m", TRUTH.c_m),
];

#[test]
fn recover_identifiable_parameters_without_noise() {
    let config = config("configs/tian.toml");
    let machine = &config.machine;
    let folder = tempfile::tempdir().unwrap();
    let peaks = peaks_of(TRUTH);
    assert!(peaks.iter().all(|p| p.len() == 4), "{peaks:?}");
    let set = write_set(folder.path(), &peaks, None, &mut || 1.0);
    // The data follow the described machine exactly, so no tolerances are fitted.
    let mut plan = IdentificationSettings { tolerances: false, ..IdentificationSettings::default() };
    plan.settings.frequency_model_error = 1e-3;
    plan.settings.amplitude_sd = 0.01;
    let found = run(machine, &set, &plan);
    for (id, truth) in IDENTIFIABLE {
        let error = error(machine, &found, id, truth);
        assert!(error.abs() < 0.005, "{id}: {:.3} %", 100.0 * error);
        let estimate = &found.estimates[machine.parameter(id).unwrap()];
        assert_eq!(estimate.identifiable, Some(true), "{id}");
    }
    assert!((found.gain.gain / GAIN - 1.0).abs() < 0.005, "{:?}", found.gain);
    // With the weights of a real test the bearing dampings are not identifiable, and are reported as such.
    let found =
        run(machine, &set, &IdentificationSettings { repeats: 1, ..IdentificationSettings::default() });
    for id in ["c_al", "c_ar"] {
        assert_eq!(found.estimates[machine.parameter(id).unwrap()].identifiable, Some(false), "{id}");
    }
}

/// Returns the median errors of the stiffnesses over `draws` noisy sets whose true stiffnesses vary by
/// ±`spread` in the logarithm.
fn median_errors(draws: u64, spread: f64) -> [f64; 4] {
    let config = config("configs/tian.toml");
    let machine = &config.machine;
    let mut errors: Vec<Vec<f64>> = vec![Vec::new(); 4];
    for draw in 0..draws {
        let folder = tempfile::tempdir().unwrap();
        let mut random = Draws(draw);
        let mut vary = |k: f64| k * (spread * (2.0 * random.next() - 1.0)).exp();
        let truth = Joints {
            k_al: vary(TRUTH.k_al),
            k_ar: vary(TRUTH.k_ar),
            k_n: vary(TRUTH.k_n),
            k_m: vary(TRUTH.k_m),
            ..TRUTH
        };
        let set =
            write_set(folder.path(), &peaks_of(truth), Some(1.0), &mut || f64::exp(0.05 * random.normal()));
        let mut plan = IdentificationSettings { repeats: 1, seed: draw, ..IdentificationSettings::default() };
        plan.settings.frequency_model_error = 1e-3;
        plan.settings.amplitude_sd = 0.05;
        let found = run(machine, &set, &plan);
        let truths = [("k_al", truth.k_al), ("k_ar", truth.k_ar), ("k_n", truth.k_n), ("k_m", truth.k_m)];
        for (list, (id, truth)) in errors.iter_mut().zip(truths) {
            list.push(error(machine, &found, id, truth).abs());
        }
    }
    let medians = errors.into_iter().map(|list| median(list).unwrap());
    let medians: Vec<f64> = medians.collect();
    println!(
        "median errors of k_al, k_ar, k_n, k_m: {:?} %",
        medians.iter().map(|m| (1e4 * m).round() / 100.0).collect::<Vec<_>>()
    );
    [medians[0], medians[1], medians[2], medians[3]]
}

/// Frequencies rounded to 1 Hz and 5 % amplitude noise, 50 machines in a study.
#[test]
#[ignore = "second tier"]
fn recover_stiffness_from_rounded_and_noisy_data() {
    let medians = median_errors(test_data::draws(16, 50), 0.2);
    assert!(medians.iter().all(|m| *m < 0.03), "{medians:?}");
}

/// For a single machine rounding biases k_m by 2–4 % in every draw, because the first mode, 23.5–23.7 Hz, is
/// rounded to 24 Hz at all three positions. The other stiffnesses are not biased in this way.
#[test]
fn recover_one_machine_as_far_as_rounding_allows() {
    let medians = median_errors(12, 0.0);
    assert!(medians[..3].iter().all(|m| *m < 0.03) && medians[3] < 0.045, "{medians:?}");
}

/// Returns for each deviation the order measured and the rank of the predicted peak.
fn pairing(objective: &ModeObjective<'_>, place: &[f64]) -> Vec<(Option<u32>, Option<usize>)> {
    let predicted = objective.predict(&objective.parameters(&Place(place.to_vec())));
    let of = |p: &PositionPrediction| {
        let rank =
            |d: &Deviation| d.predicted.and_then(|peak| p.peaks.iter().position(|known| *known == peak));
        p.deviations.iter().map(|d| (d.observed.map(|o| o.order), rank(d))).collect::<Vec<_>>()
    };
    predicted.iter().flat_map(of).collect()
}

/// The derivatives of χ² with every coordinate agree with differences at drawn places, for exact and for
/// lumped rods, with parameters that act on every kind of element and on the measuring chain, and with peaks
/// on their ramps. Where the pairing changes, amplitudes leave χ² or enter it: there nothing is compared.
#[test]
fn the_derivatives_of_modes_agree_with_differences() {
    const STEP: f64 = 1e-4;
    let machine = everything();
    let set = read_set("measurements/tian").unwrap();
    let (fit, _) = set.split(None, &[]).unwrap();
    let mut random = Draws(8);
    let (mut on_ramps, mut compared, mut changes) = (0, 0, 0);
    for rods in [RodModel::Exact, RodModel::Lumped(5)] {
        let settings = ModeSettings { rods, ..ModeSettings::default() };
        let objective = ModeObjective::new(&machine, &fit, settings, &[]).unwrap();
        let squares = ModeSquares::new(&objective, None);
        for _ in 0..20 {
            let point: Vec<f64> = (0..squares.dimension()).map(|_| 0.3 + 0.4 * random.next()).collect();
            let predicted = objective.predict(&objective.parameters(&Place(point.clone())));
            on_ramps += predicted
                .iter()
                .flat_map(|p| &p.deviations)
                .filter(|d| d.visibility > 0.0 && d.visibility < 1.0)
                .count();
            let normal = squares.normal(&point);
            assert!((normal.chi_square / squares.chi_square(&point) - 1.0).abs() < 1e-12);
            for column in 0..point.len() {
                let moved = |by: f64| {
                    let mut moved = point.clone();
                    moved[column] += by;
                    moved
                };
                if pairing(&objective, &moved(-2.0 * STEP)) != pairing(&objective, &moved(2.0 * STEP)) {
                    changes += 1;
                    continue;
                }
                let slope_over = |step: f64| {
                    (squares.chi_square(&moved(step)) - squares.chi_square(&moved(-step))) / (2.0 * step)
                };
                // Richardson's extrapolation removes the error of second order.
                let slope = (4.0 * slope_over(STEP) - slope_over(2.0 * STEP)) / 3.0;
                let exact = 2.0 * normal.gradient[column];
                let scale = (normal.information[(column, column)] * normal.chi_square).sqrt();
                // Peaks are found to 1e-9 of their frequency.
                let rounding = 1e-9 * normal.chi_square / STEP;
                compared += 1;
                assert!(
                    (slope - exact).abs() < 1e-4 * scale + rounding,
                    "{rods:?}, column {column}: {slope} against {exact}, scale {scale}"
                );
            }
        }
    }
    println!(
        "{compared} derivatives compared, {changes} where pairs change, {on_ramps} peaks on their ramps"
    );
    assert!(on_ramps > 20 && compared > 1000);
}
