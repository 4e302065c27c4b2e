//! Identification of the published bench: accuracy, invariants and regression.

use std::sync::LazyLock;

use config::effect_library;
use identification::objective::{ModeObjective, ModeSettings, Objective, PositionPrediction};
use identification::validation::{frequency_errors, leave_one_out};
use identification::{Identification, IdentificationSettings, identify};
use long_work::Control;
use machine::Machine;
use measurement::read_set;
use numeric::statistics::{root_mean_square, root_sum_square};
use optimizer::Cost;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::support::config;

fn run_on(positions: &[&str], plan: &IdentificationSettings) -> (Machine, Identification) {
    let config = config("configs/tian.toml");
    let set = read_set("measurements/tian").unwrap();
    let names: Vec<String> = positions.iter().map(|p| (*p).to_string()).collect();
    let (fit, held_out) = set.split(Some(&names), &[]).unwrap();
    let found = identify(&config.machine, &fit, &held_out, plan, &Control::default()).unwrap();
    (config.machine, found)
}

/// The result of `identify --positions l1,l3,l5`, computed once.
static DEFAULT_IDENTIFICATION: LazyLock<(Machine, Identification)> =
    LazyLock::new(|| run_on(&["l1", "l3", "l5"], &IdentificationSettings::default()));

fn all_errors(predictions: &[PositionPrediction], positions: &[usize]) -> Vec<f64> {
    predictions
        .iter()
        .filter(|p| positions.contains(&p.position))
        .flat_map(frequency_errors)
        .map(|e| e.unwrap_or(0.3))
        .collect()
}

/// Checks the required accuracy and the parameter values at default settings. The published largest frequency
/// error is 2.95 %.
#[test]
fn regress_default_identification() {
    let (machine, found) = &*DEFAULT_IDENTIFICATION;
    let largest = all_errors(&found.held_out, &[1, 3, 5]).into_iter().map(f64::abs).fold(0.0, f64::max);
    assert!(largest < 0.0295, "{largest}");
    let logs = found.fitted.iter().flat_map(|p| &p.deviations);
    let logs =
        logs.filter_map(|d| Some((found.gain.gain * d.predicted?.amplitude / d.observed?.amplitude?).ln()));
    let rms = root_mean_square(logs).unwrap();
    assert!(rms < 0.16, "{rms}");
    assert!(found.agree == Some(true) && found.complete);
    for (id, value) in [
        ("k_al", 3.980e7),
        ("k_ar", 2.891e7),
        ("k_n", 5.586e8),
        ("k_m", 399.8),
        ("c_n", 4.382e4),
        ("c_m", 0.04557),
    ] {
        let ours = found.values[machine.parameter(id).unwrap()];
        assert!((ours / value - 1.0).abs() < 2e-3, "{id}: {ours} against {value}");
    }
    assert!((found.gain.gain - 0.2766).abs() < 5e-4, "{}", found.gain.gain);
}

/// The parameters, bit by bit, and the number of evaluations are the same on one thread and on two. The
/// expected number holds for processors with FMA, because the vectorised sine rounds differently without it.
#[test]
fn regress_same_bits_and_effort_on_one_and_two_threads() {
    let plan = IdentificationSettings { seed: 7, repeats: 1, ..IdentificationSettings::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run_on(&["l1", "l3", "l5"], &plan).1)
    };
    let (one, two) = (on(1), on(2));
    assert_eq!(one.values, two.values);
    assert_eq!(one.cost.to_bits(), two.cost.to_bits());
    assert_eq!(one.evaluations, two.evaluations);
    if cfg!(target_feature = "fma") {
        assert_eq!(one.evaluations, EVALUATIONS_AT_SEED_7);
    }
}

const EVALUATIONS_AT_SEED_7: u64 = 5_776;

/// A frequency error of 1e-7 keeps populations from converging: searches then need up to four times as many
/// evaluations.
#[test]
fn limit_searches_from_any_seed_converge() {
    for seed in 1..=6 {
        let (_, found) = run_on(
            &["l1", "l3", "l5"],
            &IdentificationSettings { seed, repeats: 1, ..IdentificationSettings::default() },
        );
        assert!(found.evaluations < 10_000, "seed {seed}: {} evaluations", found.evaluations);
    }
}

/// `at_most` returns the objective's value where it is at most the limit, otherwise any value above the
/// limit. A search that uses it decides as with the full objective.
#[test]
fn limit_an_objective_that_may_stop_early_decides_like_the_full_one() {
    let config = config("configs/tian.toml");
    let set = read_set("measurements/tian").unwrap();
    let (fit, _) = set.split(None, &[]).unwrap();
    let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
    for objective in [Objective::LeastSquares, Objective::Eq26, Objective::Frequencies] {
        let settings = ModeSettings { objective, ..ModeSettings::default() };
        let problem = ModeObjective::new(&config.machine, &fit, settings, &[]).unwrap();
        for _ in 0..60 {
            let point: Vec<f64> = problem.free.iter().map(|_| random.random()).collect();
            let full = Cost::at(&problem, &point);
            for share in [0.1, 0.5, 0.99, 1.0, 1.01, 2.0] {
                let (limit, early) = (share * full, problem.at_most(&point, share * full));
                assert!(
                    if full <= limit { early == full } else { early > limit },
                    "{objective:?}: {early} for {full}, limit {limit}"
                );
            }
        }
    }
}

/// After a first pass has reserved memory for the peaks, an evaluation allocates nothing at any parameter
/// values.
#[test]
fn limit_an_objective_on_modes_allocates_nothing() {
    let config = config("configs/tian.toml");
    let set = read_set("measurements/tian").unwrap();
    let (fit, _) = set.split(None, &[]).unwrap();
    let problem = ModeObjective::new(&config.machine, &fit, ModeSettings::default(), &[]).unwrap();
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let points: Vec<Vec<f64>> =
        (0..40).map(|_| problem.free.iter().map(|_| random.random()).collect()).collect();
    let all = || points.iter().map(|point| problem.at_most(point, f64::INFINITY)).sum::<f64>();
    let once = all();
    let mut again = 0.0;
    let counted = allocation_counter::measure(|| again = all());
    assert_eq!(counted.count_total, 0, "{counted:?}");
    assert_eq!(again.to_bits(), once.to_bits());
}

/// A fit to three positions predicts l2, l4, l6 better than a fit to any one of them (published: 4.63 %
/// against 5.60 and 14.19 %).
#[test]
fn published_multi_position_is_better_than_single() {
    let held = [1, 3, 5];
    let score = |found: &Identification| root_sum_square(all_errors(&found.held_out, &held)).unwrap();
    let multi = score(&DEFAULT_IDENTIFICATION.1);
    for single in ["l1", "l3", "l5"] {
        let alone = score(&run_on(&[single], &IdentificationSettings::default()).1);
        assert!(multi < alone, "{single}: {alone} against {multi}");
    }
}

/// One position gives 8 observations for 9 unknowns, and a warning reports it.
#[test]
fn limit_fewer_observations_than_unknowns_are_reported() {
    let (_, found) =
        run_on(&["l3"], &IdentificationSettings { repeats: 1, ..IdentificationSettings::default() });
    assert!(
        found.warnings.iter().any(|w| w.contains("8 observations cannot determine 9 unknowns")),
        "{:?}",
        found.warnings
    );
    assert!(found.estimates.iter().any(|e| e.identifiable == Some(false)));
}

/// Among the objectives that use amplitudes, the default predicts left-out positions best; l2, l4, l6 are not
/// used.
#[test]
fn regress_default_objective_is_best_in_leave_one_position_out() {
    let config = config("configs/tian.toml");
    let set = read_set("measurements/tian").unwrap();
    let (fit, _) = set.split(None, &[]).unwrap();
    let plan = IdentificationSettings { repeats: 1, ..IdentificationSettings::default() };
    let objectives = [Objective::LeastSquares, Objective::Eq26, Objective::Frequencies];
    let scores = leave_one_out(&config.machine, &fit, &plan, &objectives, &Control::default()).unwrap();
    println!("{scores:?}");
    let rank = |o: Objective| scores.iter().position(|s| s.objective == o).unwrap();
    assert!(rank(Objective::LeastSquares) < rank(Objective::Eq26), "{scores:?}");
}

/// Damping of the guide, which the shipped description of the bench lacks, does not predict left-out
/// positions among l1, l3 and l5 better, and these do not determine it.
#[test]
fn regress_guide_damping_of_the_bench_in_leave_one_position_out() {
    let machine = config("configs/tian.toml").machine;
    let library = effect_library().unwrap();
    let with = machine.with_effect(library.iter().find(|e| e.id == "guide-viscous").unwrap()).unwrap();
    let set = read_set("measurements/tian").unwrap();
    let (fit, held_out) = set.split(None, &[]).unwrap();
    let plan = IdentificationSettings::default();
    let [without, with_damping] = [&machine, &with].map(|machine| {
        let plan = IdentificationSettings { repeats: 1, ..plan.clone() };
        let score = leave_one_out(machine, &fit, &plan, &[Objective::LeastSquares], &Control::default())
            .unwrap()
            .remove(0);
        println!(
            "frequency error {:.4}, ln amplitude {:.3?}",
            score.frequency_error, score.ln_amplitude_error
        );
        score
    });
    assert!(
        with_damping.frequency_error > 0.98 * without.frequency_error,
        "{with_damping:?} against {without:?}"
    );
    let found = identify(&with, &fit, &held_out, &plan, &Control::default()).unwrap();
    let guide = &found.estimates[with.parameter("c_guide").unwrap()];
    println!("c_guide {:.0}, {:.0?}", guide.value, guide.interval95);
    assert_eq!(guide.identifiable, Some(false));
}

/// The paper's overall errors follow from its printed frequencies (Eq. 27).
#[test]
fn published_overall_errors_follow_from_the_printed_frequencies() {
    let set = read_set("measurements/tian").unwrap();
    let table = set.modes.as_ref().unwrap();
    let names = |text: &str| -> Vec<String> { text.split('+').map(str::to_string).collect() };
    for (fit, position, percent) in [
        ("l1+l3+l5", "l2", 2.71),
        ("l1+l3+l5", "l4", 0.96),
        ("l1+l3+l5", "l6", 3.63),
        ("l1+l3+l5", "l3", 2.31),
        ("l1+l3+l5", "l5", 2.99),
        ("l3", "l2", 3.09),
        ("l3", "l4", 1.26),
        ("l3", "l6", 4.51),
        ("l5", "l2", 12.19),
        ("l5", "l4", 6.67),
        ("l5", "l6", 2.86),
    ] {
        let at = set.positions.iter().position(|p| p.name == position).unwrap();
        let errors = table.positions[at].iter().filter_map(|m| {
            let published = set.published.predicted_hz(&names(fit), position, m.order)?;
            Some(published / m.frequency_hz? - 1.0)
        });
        let overall = 100.0 * root_sum_square(errors).unwrap();
        assert!((overall - percent).abs() < 0.021, "{fit} at {position}: {overall:.3} against {percent}");
    }
}

/// Changed held-out data leave every bit of the fit unchanged.
#[test]
fn limit_held_out_data_do_not_reach_the_fit() {
    let config = config("configs/tian.toml");
    let set = read_set("measurements/tian").unwrap();
    let mut other = set.clone();
    let table = other.modes.as_mut().unwrap();
    table.positions[5][3].frequency_hz = Some(1500.0);
    table.positions[1][0].frequency_hz = Some(12.4);
    let plan = IdentificationSettings { repeats: 1, ..IdentificationSettings::default() };
    let values = |set: &measurement::MeasurementSet| {
        let (fit, held_out) = set.split(None, &[]).unwrap();
        identify(&config.machine, &fit, &held_out, &plan, &Control::default()).unwrap().values
    };
    assert_eq!(values(&set), values(&other));
}

/// The interval of the gain is wide because gain and damping are correlated. A refit with the gain fixed at
/// 0.2 increases χ² by 4 to 5 at a misfit of 2.5.
#[test]
fn regress_the_gain_is_less_certain_than_the_amplitudes() {
    let (_, found) = run_on(
        &["l1", "l3", "l5"],
        &IdentificationSettings { repeats: 1, ..IdentificationSettings::default() },
    );
    let (low, high) = found.gain_interval95.unwrap();
    assert!(low < 0.22 && high > 0.33, "{low} {high}");
}
