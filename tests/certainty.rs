//! Coverage of intervals: intervals of identifiable values contain the true values. The reference simulator
//! draws the machines; they deviate from their description by manufacturing tolerances alone.

use std::collections::BTreeMap;
use std::path::Path;

use identification::objective::{FrfObjective, FrfSettings};
use identification::{Drawn, FrfPlan, Identification, IdentificationSettings, PlanDesign, identify};
use jointid::{Study, read_machine};
use long_work::Control;
use machine::{Machine, ParameterValues, State};
use measurement::{FrfLine, read_set};
use nalgebra::{DMatrix, DVector};
use numeric::distribution::clopper_pearson;
use numeric::statistics::median;
use reference_simulator::{Ordinary, ordinary, ordinary_on_guide, write_case};
use test_data::{draws, is_study};

/// Estimate of one parameter of one machine, compared with its true value.
pub(crate) struct ParameterResult {
    pub(crate) id: String,
    /// ln(estimate/truth).
    pub(crate) log_error: f64,
    /// Width of the 95 % interval of the logarithm.
    width: f64,
    pub(crate) identifiable: bool,
    /// Whether the interval misses the true value.
    pub(crate) missed: bool,
}

fn read(simulated: &Ordinary, folder: &Path) -> (Machine, measurement::MeasurementSet) {
    write_case(folder, &simulated.case).unwrap();
    let config = config::read_machine(&folder.join("machine.toml").display().to_string(), &[], &[]).unwrap();
    (config.machine, read_set(&folder.display().to_string()).unwrap())
}

pub(crate) fn identified(machine: &Machine, set: &measurement::MeasurementSet) -> Identification {
    let (fit, held_out) = set.split(None, &[]).unwrap();
    let plan =
        IdentificationSettings { frf: Some(FrfSettings::default()), ..IdentificationSettings::default() };
    identify(machine, &fit, &held_out, &plan, &Control::default()).unwrap()
}

pub(crate) fn compare_with_truth(
    truth: &BTreeMap<String, f64>,
    machine: &Machine,
    found: &Identification,
) -> Vec<ParameterResult> {
    let of = |estimate: &identification::Estimate| {
        let id = &machine.parameters[estimate.parameter].id;
        let (truth, (low, high)) = (*truth.get(id)?, estimate.interval95?);
        Some(ParameterResult {
            id: id.clone(),
            log_error: (estimate.value / truth).ln(),
            width: (high / low).ln(),
            identifiable: estimate.identifiable == Some(true),
            missed: !(low..=high).contains(&truth),
        })
    };
    found.estimates.iter().filter_map(of).collect()
}

/// Replaces the FRFs of the machine's set by their peaks, read at the nearest line.
fn with_modes(simulated: &Ordinary, folder: &Path) -> measurement::MeasurementSet {
    let manifest = std::fs::read_to_string(folder.join("manifest.toml")).unwrap();
    let (head, rest) = manifest.split_once("[[frf]]").unwrap();
    assert!(rest.contains("l6"));
    let keys = format!("modes = \"modes.csv\"\nfrequency_resolution_hz = {}\naverages", simulated.step_hz);
    std::fs::write(folder.join("manifest.toml"), head.replacen("averages", &keys, 1)).unwrap();
    let mut modes = String::from("position,order,frequency_hz,amplitude\n");
    for (at, peaks) in simulated.peaks.iter().enumerate() {
        for (order, (hz, amplitude)) in peaks.iter().enumerate() {
            modes += &format!("l{},{},{hz:e},{amplitude:e}\n", at + 1, order + 1);
        }
    }
    std::fs::write(folder.join("modes.csv"), modes).unwrap();
    read_set(&folder.display().to_string()).unwrap()
}

/// Intervals from natural frequencies and amplitudes cover the true values as often as those from FRFs,
/// though modes determine few parameters.
///
/// With the covariance of tolerances at most 5 % of the stiffnesses reported as identifiable miss. A study
/// prints the run without it for comparison.
#[test]
#[ignore = "long"]
fn recover_ordinary_machines_from_modes() {
    let (seed, count) = (5_107, draws(6, 60) as usize);
    for tolerances in [true, false].into_iter().filter(|tolerances| *tolerances || is_study()) {
        let (mut called, mut missed, mut all, mut all_missed) = (0, 0, 0, 0);
        for number in 0..count {
            let simulated = ordinary(seed, number).unwrap();
            let folder = tempfile::tempdir().unwrap();
            let (machine, _) = read(&simulated, folder.path());
            let set = with_modes(&simulated, folder.path());
            let (fit, held_out) = set.split(None, &[]).unwrap();
            let plan = IdentificationSettings { tolerances, ..IdentificationSettings::default() };
            let found = identify(&machine, &fit, &held_out, &plan, &Control::default()).unwrap();
            for t in compare_with_truth(&simulated.truth, &machine, &found)
                .iter()
                .filter(|t| t.id.starts_with('k'))
            {
                (all, all_missed) = (all + 1, all_missed + usize::from(t.missed));
                (called, missed) =
                    (called + usize::from(t.identifiable), missed + usize::from(t.identifiable && t.missed));
            }
        }
        println!(
            "tolerances {tolerances}: {missed} of {called} stiffnesses reported as identifiable miss, {all_missed} of all {all} intervals"
        );
        if tolerances {
            assert!(
                missed as f64 <= (0.05 * called as f64).max(2.0) && all_missed as f64 <= 0.15 * all as f64
            );
        }
    }
}

/// Required: at most 5 % of the values reported as identifiable miss the true value, by a one-sided test at 5
/// % with machines, not values, as draws.
///
/// Of the stiffnesses reported as identifiable at most 2 % deviate by more than a tenth. At least four of
/// five stiffnesses are identifiable.
#[test]
#[ignore = "long"]
fn recover_ordinary_machines_with_intervals_that_hold() {
    let (seed, count) = (9_173, draws(6, 60) as usize);
    let mut all: Vec<Vec<ParameterResult>> = Vec::new();
    for number in 0..count {
        let simulated = ordinary(seed, number).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let (machine, set) = read(&simulated, folder.path());
        let found = identified(&machine, &set);
        let values = compare_with_truth(&simulated.truth, &machine, &found);
        let missed: Vec<String> = values
            .iter()
            .filter(|t| t.missed || (t.identifiable && t.id.starts_with('k') && t.log_error.abs() > 0.1))
            .map(|t| {
                format!(
                    "{}{} {:+.1} % width {:.3}",
                    if t.identifiable { "" } else { "(open) " },
                    t.id,
                    100.0 * t.log_error,
                    t.width
                )
            })
            .collect();
        println!(
            "{number} {} s {:.2} chi2/n {:.3}: {}",
            simulated.size,
            simulated.loss_dispersion,
            found.chi_square / found.degrees_of_freedom as f64,
            missed.join(", ")
        );
        all.push(values);
    }
    let identifiable = || all.iter().flatten().filter(|t| t.identifiable);
    let (called, missed) = (identifiable().count(), identifiable().filter(|t| t.missed).count());
    let stiffness = |t: &&ParameterResult| t.id.starts_with('k');
    let (stiff, off) = (
        identifiable().filter(stiffness).count(),
        identifiable().filter(stiffness).filter(|t| t.log_error.abs() > 0.1).count(),
    );
    let stiffnesses = all.iter().flatten().filter(stiffness).count();
    let upper = |k: usize, n: usize| clopper_pearson(k, n, 0.95).map_or(1.0, |[_, high]| high);
    println!(
        "identifiable {called}, missed {missed} ({:.1} %, 95 % below {:.1} %)",
        100.0 * missed as f64 / called as f64,
        100.0 * upper(missed, called)
    );
    println!(
        "stiffnesses identifiable {stiff} of {stiffnesses}, deviating by more than a tenth {off} (95 % below {:.1} %)",
        100.0 * upper(off, stiff)
    );
    for id in ["k_al", "k_ar", "k_n", "k_m", "k_s", "c_al", "c_ar", "c_n", "c_m", "c_s"] {
        let own = || all.iter().flatten().filter(|t| t.id == id);
        let width = median(own().filter(|t| t.identifiable).map(|t| t.width)).unwrap_or(f64::NAN);
        let off = median(own().map(|t| t.log_error.abs())).unwrap_or(f64::NAN);
        println!(
            "{id}: identifiable {}, missed {}, median width {width:.3}, median deviation {:.1} %",
            own().filter(|t| t.identifiable).count(),
            own().filter(|t| t.identifiable && t.missed).count(),
            100.0 * off
        );
    }
    // Machines are the draws: the excess of each machine's misses over 5 % of its values, tested against
    // zero.
    let excess: Vec<f64> = all
        .iter()
        .map(|values| {
            let own = || values.iter().filter(|t| t.identifiable);
            own().filter(|t| t.missed).count() as f64 - 0.05 * own().count() as f64
        })
        .collect();
    let mean = excess.iter().sum::<f64>() / count as f64;
    let sd = (excess.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count as f64 - 1.0)).sqrt();
    let z = mean / (sd / (count as f64).sqrt()).max(1e-9);
    println!("misses in excess of 5 %: {mean:.3} per machine, z = {z:.2}");
    assert!(z < 1.645, "more than 5 % of the values reported as identifiable miss the true value");
    assert!(
        off as f64 <= (0.02 * stiff as f64).max(1.0),
        "stiffnesses reported as identifiable deviate by more than a tenth"
    );
    assert!(stiff as f64 >= 0.8 * stiffnesses as f64, "too few stiffnesses are identifiable");
}

/// Values of machines on a guide whose damping the description lacks, which also have tolerances and losses
/// of their joints.
///
/// Required: 95 % intervals of stiffnesses hold the true value at least 90 % of the time, those of dampings
/// 85 %. Values that depend on what the model lacks are not reported as identifiable.
#[test]
#[ignore = "long"]
fn recover_machines_on_an_undescribed_guide() {
    let (seed, count) = (15_331, draws(6, 60) as usize);
    let mut all: Vec<ParameterResult> = Vec::new();
    for number in 0..count {
        let simulated = ordinary_on_guide(seed, number).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let (machine, set) = read(&simulated, folder.path());
        let found = identified(&machine, &set);
        let values = compare_with_truth(&simulated.truth, &machine, &found);
        let depends = found.estimates.iter().filter(|e| e.depends).count();
        let missed: Vec<String> = values
            .iter()
            .filter(|t| t.missed)
            .map(|t| {
                format!(
                    "{}{} {:+.1} % width {:.3}",
                    if t.identifiable { "" } else { "(open) " },
                    t.id,
                    100.0 * t.log_error,
                    t.width
                )
            })
            .collect();
        println!(
            "{number} {} guide {:.1} 1/s, chi2/n {:.3}, correlation {:.2}, depend {depends}: {}",
            simulated.size,
            simulated.guide_per_s,
            found.chi_square / found.degrees_of_freedom as f64,
            found.correlation_factor,
            missed.join(", ")
        );
        all.extend(values);
    }
    for (kind, least) in [('k', 0.9), ('c', 0.85)] {
        let own = || all.iter().filter(|t| t.id.starts_with(kind));
        let (of, held) = (own().count(), own().filter(|t| !t.missed).count());
        let called = || own().filter(|t| t.identifiable);
        println!(
            "{kind}: {held} of {of} intervals hold ({:.1} %, {:?}); reported as identifiable {}, of which {} hold; median width {:.3}",
            100.0 * held as f64 / of as f64,
            clopper_pearson(held, of, 0.95),
            called().count(),
            called().filter(|t| !t.missed).count(),
            median(own().map(|t| t.width)).unwrap_or(f64::NAN)
        );
        assert!(held as f64 >= least * of as f64, "{kind}: {held} of {of} intervals hold the true value");
    }
}

/// A wrong number of a description: where it stands in the file, and by what it is multiplied.
pub(crate) type WrongNumber = (&'static str, fn(&mut toml::Table) -> &mut toml::Value, f64);

/// Returns an entry of a list of a machine file, by its name.
fn entry<'t>(file: &'t mut toml::Table, list: &str, name: &str) -> &'t mut toml::Value {
    let all = file[list].as_array_mut().unwrap();
    all.iter_mut().find(|entry| entry["name"].as_str() == Some(name)).unwrap()
}

pub(crate) const WRONG_NUMBERS: [WrongNumber; 5] = [
    ("mass of table", |file| &mut entry(file, "point", "table")["mass_kg"], 0.93),
    ("inertia of rotor", |file| &mut entry(file, "point", "rotor")["inertia_kg_m2"], 1.3),
    ("lead", |file| &mut entry(file, "joint", "nut")["screw"]["lead_m"], 0.85),
    ("diameter of screw", |file| &mut file["shaft"][0]["diameter_m"], 1.05),
    ("Young's modulus of screw", |file| &mut file["shaft"][0]["youngs_modulus_pa"], 0.93),
];

/// Values of machines of which one number is described wrongly.
///
/// Required: at most 7 % of the stiffnesses reported as identifiable miss the true value, by a one-sided test
/// at 5 %: nothing is called identifiable that depends on the wrong number. Machines described rightly keep
/// theirs, see `recover_ordinary_machines_with_intervals_that_hold`.
#[test]
#[ignore = "long"]
fn recover_nothing_false_from_wrong_descriptions() {
    let (seed, count) = (60_227, draws(2, 20) as usize);
    let (mut called, mut missed, mut depending, mut depending_missed) = (0, 0, 0, 0);
    for number in 0..count {
        let simulated = ordinary(seed, number).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let (_, set) = read(&simulated, folder.path());
        let text = std::fs::read_to_string(folder.path().join("machine.toml")).unwrap();
        for (name, entry_of, factor) in WRONG_NUMBERS {
            let mut file: toml::Table = text.parse().unwrap();
            let stated = entry_of(&mut file);
            *stated = toml::Value::Float(stated.as_float().unwrap() * factor);
            let machine = config::read_machine_text("wrong", &file.to_string(), &[], &[]).unwrap().machine;
            let found = identified(&machine, &set);
            let is_stiffness = |row: &&ParameterResult| row.id.starts_with('k');
            let rows = compare_with_truth(&simulated.truth, &machine, &found);
            let depends = |row: &&ParameterResult| {
                found.estimates.iter().any(|e| e.depends && machine.parameters[e.parameter].id == row.id)
            };
            let stiffnesses: Vec<&ParameterResult> = rows.iter().filter(is_stiffness).collect();
            let false_ones = stiffnesses.iter().filter(|row| row.identifiable && row.missed).count();
            called += stiffnesses.iter().filter(|row| row.identifiable).count();
            missed += false_ones;
            depending += stiffnesses.iter().filter(|row| depends(row)).count();
            depending_missed += stiffnesses.iter().filter(|row| depends(row) && row.missed).count();
            let doubts: Vec<String> = found.doubts.iter().map(ToString::to_string).collect();
            println!("{} {name}: {false_ones} miss; {}", simulated.size, doubts.join("; "));
        }
    }
    println!(
        "stiffnesses identifiable {called}, missed {missed}; depending {depending}, missed {depending_missed}"
    );
    let [lower, _] = clopper_pearson(missed, called, 0.9).expect("some values are identifiable");
    assert!(lower <= 0.07, "{missed} of {called} stiffnesses reported as identifiable miss");
    assert!(depending_missed > missed, "wrong numbers change values: {depending_missed} of {depending}");
}

/// A plan promises the intervals that an identification of the same measurements finds: tolerances of
/// machine, nut positions and channels count in both.
#[test]
#[ignore = "long"]
fn recover_the_intervals_that_a_plan_promises() {
    let mut ratios = Vec::new();
    for number in 0..draws(2, 12) as usize {
        let simulated = ordinary(31_277, number).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let (machine, set) = read(&simulated, folder.path());
        let found = identified(&machine, &set);
        let fitted = &set.frfs[0];
        let noise = median(fitted.component_sds().into_iter().flatten()).unwrap() * 2.0_f64.sqrt();
        let hz = |at: Option<&FrfLine>| at.unwrap().frequency_hz;
        let plan = FrfPlan {
            noise,
            band_hz: (hz(fitted.lines.first()), hz(fitted.lines.last())),
            lines: fitted.lines.len(),
        };
        let values = ParameterValues(found.values[..machine.parameters.len()].to_vec());
        let channel = (fitted.response.clone(), fitted.excitation.clone());
        let among = (&[channel][..], &[State::Described][..]);
        let design =
            PlanDesign::of_frfs(&machine, &values, &set, among, plan, FrfSettings::default(), &[]).unwrap();
        let (fit, _) = set.split(None, &[]).unwrap();
        let chosen =
            |at: &usize| design.candidates[*at].position.is_some_and(|p| fit.positions().contains(&p));
        let choice = design.choice(&(0..design.candidates.len()).filter(chosen).collect::<Vec<usize>>());
        for (column, index) in design.free.iter().enumerate() {
            let parameter = &machine.parameters[*index];
            let estimate = &found.estimates[*index];
            let Some((low, high)) = estimate.interval95.filter(|_| parameter.id.starts_with('k')) else {
                continue;
            };
            let width = parameter.to_unit(high) - parameter.to_unit(low);
            // Where the data determine a parameter, its region is near to an ellipsoid.
            if estimate.identifiable == Some(true) {
                ratios.push(2.0 * 1.96 * choice.sd[column] / width);
                println!("{number} {}: {:.2}", parameter.id, ratios.last().unwrap());
            }
        }
    }
    let middle = median(ratios.iter().copied()).unwrap();
    println!("promised over found width: median {middle:.2} of {}", ratios.len());
    assert!((0.7..1.4).contains(&middle), "{ratios:?}");
}

/// One line, a band without a mode, a coherence of 1 throughout: intervals as wide as the data leave them,
/// and a warning that says what to measure.
#[test]
fn limit_little_data_determine_nothing() {
    let simulated = ordinary(52_771, 0).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (_, set) = read(&simulated, folder.path());
    let machine = folder.path().join("machine.toml").display().to_string();
    let lowest = simulated.peaks.iter().flatten().map(|(hz, _)| *hz).fold(f64::INFINITY, f64::min);
    let identified = |edit: &dyn Fn(&mut Vec<FrfLine>)| {
        let mut other = set.clone();
        other.frfs.iter_mut().for_each(|frf| edit(&mut frf.lines));
        Study::new(read_machine(&machine).unwrap(), other).identify().unwrap()
    };
    let one = identified(&|lines| {
        let middle = lines.len() / 10;
        *lines = vec![lines[middle]];
    });
    let modeless =
        identified(&|lines| lines.retain(|line| (0.2 * lowest..0.3 * lowest).contains(&line.frequency_hz)));
    for (found, warning) in
        [(one, "cannot determine"), (modeless, "no natural frequency of the fitted machine lies in the band")]
    {
        assert!(
            found.parameters.values().all(|row| row.identifiable != Some(true)),
            "{:#?}",
            found.parameters
        );
        assert!(found.stamp.warnings.iter().any(|w| w.contains(warning)), "{:#?}", found.stamp.warnings);
    }
}

/// Covariance of weighted residuals by noise and a smooth discrepancy of ln H: 1 + s²·exp(−½(Δln ω/ℓ)²)
/// within a record, with s and ℓ of greatest likelihood.
struct Discrepancy {
    /// Variance relative to that of the noise.
    variance: f64,
    /// Correlation length of ln ω.
    length: f64,
    /// Covariance of the lines of each record, for real and imaginary parts alike.
    covariance: Vec<DMatrix<f64>>,
}

impl Discrepancy {
    /// Fits it to residuals, two to a line.
    fn fitted(residuals: &DVector<f64>, frequencies_hz: &[Vec<f64>]) -> Self {
        let covariance = |variance: f64, length: f64| -> Vec<DMatrix<f64>> {
            let entry = |a: f64, b: f64| {
                variance * (-0.5 * ((a / b).ln() / length).powi(2)).exp() + if a == b { 1.0 } else { 0.0 }
            };
            frequencies_hz
                .iter()
                .map(|hz| DMatrix::from_fn(hz.len(), hz.len(), |i, j| entry(hz[i], hz[j])))
                .collect()
        };
        let deviance = |all: &[DMatrix<f64>]| -> f64 {
            let mut first = 0;
            let of = |lines: &DMatrix<f64>| {
                let factor = lines.clone().cholesky().unwrap();
                let part = |p: usize| DVector::from_fn(lines.nrows(), |i, _| residuals[2 * (first + i) + p]);
                let log_determinant: f64 = factor.l_dirty().diagonal().iter().map(|d| 2.0 * d.ln()).sum();
                let sum: f64 =
                    [0, 1].map(|p| part(p).dot(&factor.solve(&part(p))) + log_determinant).iter().sum();
                first += lines.nrows();
                sum
            };
            all.iter().map(of).sum()
        };
        let candidates = [0.0, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0]
            .into_iter()
            .flat_map(|v| [0.01, 0.03, 0.1, 0.3].map(|length| (v, length)));
        let ranked = candidates.map(|(v, length)| (deviance(&covariance(v, length)), v, length));
        let (_, variance, length) = ranked.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        Discrepancy { variance, length, covariance: covariance(variance, length) }
    }

    /// Computes the standard deviations of least-squares coordinates whose residuals have this covariance;
    /// the last rows are priors.
    fn sd(&self, slopes: &DMatrix<f64>) -> DVector<f64> {
        let inverse = (slopes.transpose() * slopes).pseudo_inverse(1e-12).unwrap();
        let data = 2 * self.covariance.iter().map(DMatrix::nrows).sum::<usize>();
        let priors = slopes.rows(data, slopes.nrows() - data);
        let mut middle = priors.transpose() * priors;
        let mut first = 0;
        for lines in &self.covariance {
            for part in [0, 1] {
                let own = DMatrix::from_fn(lines.nrows(), slopes.ncols(), |i, column| {
                    slopes[(2 * (first + i) + part, column)]
                });
                middle += own.transpose() * lines * &own;
            }
            first += lines.nrows();
        }
        (&inverse * middle * &inverse).diagonal().map(|v| v.max(0.0).sqrt())
    }
}

/// Ways to count in intervals that misfit is not noise, on machines that differ from their description within
/// tolerances, and stand on a guide that it lacks. Where no tolerance is fitted along: the variance factor by
/// misfit and correlation of the residuals; a bootstrap over runs of lines; and noise with a smooth
/// discrepancy of ln H. Beside them, tolerances fitted along, as `identify` does. How often each holds, and
/// how wide it is.
///
/// Required: tolerances hold most often, stiffnesses in 90 % and dampings in 85 %. Without them no value that
/// misses is called identifiable: the misfit exceeds the noise so far that values depend on what the model
/// lacks.
#[test]
#[ignore = "long"]
fn ways_to_count_discrepancy_in_intervals_are_compared() {
    let (seed, count) = (27_011, draws(2, 30) as usize);
    // Way, kind of parameter, held, width.
    let mut all: Vec<(&str, char, bool, f64)> = Vec::new();
    let (mut depend, mut called, mut missed) = (0, 0, 0);
    for number in 0..count {
        let simulated = ordinary_on_guide(seed, number).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let (machine, set) = read(&simulated, folder.path());
        let (fit, held_out) = set.split(None, &[]).unwrap();
        let settings = FrfSettings::default();
        let plan = IdentificationSettings {
            frf: Some(settings),
            tolerances: false,
            bootstrap: 40,
            ..IdentificationSettings::default()
        };
        let found = identify(&machine, &fit, &held_out, &plan, &Control::default()).unwrap();
        let tolerant = identified(&machine, &set);
        let objective = FrfObjective::new(&machine, &fit, settings, &[]).unwrap();
        let frequencies_hz: Vec<Vec<f64>> = fit
            .frfs()
            .iter()
            .map(|frf| set.frfs[*frf].lines.iter().map(|line| line.frequency_hz).collect())
            .collect();
        assert_eq!(objective.lines(), frequencies_hz.iter().map(Vec::len).collect::<Vec<_>>());
        let discrepancy = Discrepancy::fitted(&objective.rows(&found.place), &frequencies_hz);
        let sd = discrepancy.sd(&objective.slopes(&found.place));
        let by_lines = found.bootstraps.iter().find(|b| b.drawn == Drawn::Lines).unwrap();
        println!(
            "{number} chi2/n {:.2}, correlation {:.1}, discrepancy: variance {}, length {}",
            found.chi_square / found.degrees_of_freedom as f64,
            found.correlation_factor,
            discrepancy.variance,
            discrepancy.length
        );
        for (column, &index) in found.free.iter().enumerate() {
            let parameter = &machine.parameters[index];
            let Some(truth) = simulated.truth.get(&parameter.id) else { continue };
            let here = found.place[column];
            let unit = |(low, high): (f64, f64)| (parameter.to_unit(low), parameter.to_unit(high));
            let ways = [
                ("variance factor", unit(found.estimates[index].interval95.unwrap())),
                ("bootstrap of lines", by_lines.interval95[column]),
                ("smooth discrepancy", (here - 1.96 * sd[column], here + 1.96 * sd[column])),
                ("tolerances", unit(tolerant.estimates[index].interval95.unwrap())),
            ];
            let kind = parameter.id.chars().next().unwrap();
            let holds = |(low, high): (f64, f64)| (low..=high).contains(&parameter.to_unit(*truth));
            all.extend(ways.map(|(way, interval)| (way, kind, holds(interval), interval.1 - interval.0)));
            let estimate = &found.estimates[index];
            depend += usize::from(estimate.depends);
            called += usize::from(estimate.identifiable == Some(true));
            missed += usize::from(estimate.identifiable == Some(true) && !holds(ways[0].1));
        }
    }
    println!(
        "without tolerances {depend} values depend on what the model lacks, {called} are called identifiable, {missed} of these miss"
    );
    assert!(depend > 0 && missed == 0);
    let held = |way: &str, kind: char| {
        let own = || all.iter().filter(|(w, k, ..)| *w == way && *k == kind);
        let (held, of) = (own().filter(|(_, _, held, _)| *held).count(), own().count());
        println!(
            "{way}, {kind}: {held} of {of} hold ({:.1} %), median width {:.4} of the range",
            100.0 * held as f64 / of as f64,
            median(own().map(|(.., width)| *width)).unwrap_or(f64::NAN)
        );
        (held, of)
    };
    for (kind, least) in [('k', 0.9), ('c', 0.85)] {
        let others =
            ["variance factor", "bootstrap of lines", "smooth discrepancy"].map(|way| held(way, kind).0);
        let (used, of) = held("tolerances", kind);
        assert!(
            others.iter().all(|other| used >= *other) && used as f64 >= least * of as f64,
            "{kind}: {used} of {of}"
        );
    }
}
