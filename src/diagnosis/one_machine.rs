//! Whether records belong to one passive machine, and to the described one. Where they do not, no effect
//! explains them, however much it reduces χ².

use rayon::prelude::*;

use super::facts::Farthest;
use super::fit::{Fitted, values_of};
use super::hypothesis::Hypothesis;
use super::policy::ACTIVE_RECORDS;
use measurement::modal::{CurveOptions, ModalFit, TrackRecord, fit_curve, track, with_curve_of};
use measurement::{Activity, Frf, MeasurementSet};

/// Least number of records at different nut positions over which a mode can be regular.
const LEAST_RECORDS: usize = 3;
/// A reason why records are not those of one passive machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mismatch {
    /// No mode continues from position to position.
    NoRegularMode {
        /// Number of records.
        records: usize,
    },
    /// Driving points whose imaginary part has the sign of an active structure.
    ActiveDrivingPoints {
        /// Their number.
        active: usize,
        /// Number of all driving points.
        all: usize,
    },
}

impl Mismatch {
    /// Describes it, with a proposed measurement.
    pub fn text(self) -> (String, &'static str) {
        match self {
            Mismatch::NoRegularMode { records } => (
                format!(
                    "the records do not belong to one machine: no mode continues over the nut positions of these {records} records"
                ),
                "check to which machine and position each record belongs",
            ),
            Mismatch::ActiveDrivingPoints { active, all } => (
                format!(
                    "the records are not those of a passive machine: at {active} of {all} driving points the imaginary part of the receptance \
                     has the wrong sign over much of the band"
                ),
                "check points, directions and signs of the sensors, and which quantity was measured",
            ),
        }
    }
}

/// Returns why FRFs do not belong to one passive machine; `None` where nothing speaks against it.
pub(super) fn mismatch(set: &MeasurementSet, frfs: &[usize]) -> Option<Mismatch> {
    let records: Vec<&Frf> = frfs.iter().map(|at| &set.frfs[*at]).collect();
    let driving: Vec<Activity> = records.iter().filter_map(|frf| frf.activity()).collect();
    let active = driving.iter().filter(|activity| activity.exceeds_phase_errors()).count();
    if active >= ACTIVE_RECORDS.0 && active as f64 >= ACTIVE_RECORDS.1 * driving.len() as f64 {
        return Some(Mismatch::ActiveDrivingPoints { active, all: driving.len() });
    }
    (regular_modes(set, &records)? == 0).then_some(Mismatch::NoRegularMode { records: records.len() })
}

/// Returns the number of the machine that a fit moves farthest, with its deviation in standard deviations of
/// its tolerance; `None` where all are exact.
pub(super) fn farthest((hypothesis, fitted): (&Hypothesis, &Fitted)) -> Option<Farthest> {
    let values = values_of(hypothesis, fitted);
    let numbers =
        hypothesis.machine.parameters.iter().zip(values).filter(|(parameter, _)| parameter.is_tolerance());
    let deviations = numbers.filter_map(|(parameter, value)| {
        let deviation = parameter.prior?.deviation(parameter.start, value);
        Some(Farthest { name: parameter.name().into(), deviation })
    });
    deviations.max_by(|a, b| a.deviation.abs().total_cmp(&b.deviation.abs()))
}

/// Returns the number of modes that continue over the nut positions; `None` where there are too few records
/// or one has too few lines.
fn regular_modes(set: &MeasurementSet, records: &[&Frf]) -> Option<usize> {
    let nut_m = |frf: &Frf| frf.position.and_then(|position| set.positions[position].nut_m);
    let mut nuts_m: Vec<f64> = records.iter().filter_map(|frf| nut_m(frf)).collect();
    nuts_m.sort_by(f64::total_cmp);
    nuts_m.dedup();
    if nuts_m.len() < LEAST_RECORDS {
        return None;
    }
    let fits: Option<Vec<ModalFit>> = records
        .par_iter()
        .map(|frf| with_curve_of(frf, |_| true, |curve| fit_curve(curve, &CurveOptions::default())).ok())
        .collect();
    let fits = fits?;
    let series: Vec<String> =
        records.iter().map(|frf| format!("{}/{}", frf.response, frf.excitation)).collect();
    let end_hz = |line: Option<&measurement::FrfLine>| line.map_or(0.0, |line| line.frequency_hz);
    let tracked: Vec<TrackRecord<'_>> = records
        .iter()
        .zip(&fits)
        .zip(&series)
        .map(|((frf, fit), series)| TrackRecord {
            nut_m: nut_m(frf),
            series,
            band_hz: (end_hz(frf.lines.first()), end_hz(frf.lines.last())),
            modes: &fit.modes,
        })
        .collect();
    Some(track(&tracked).iter().filter(|mode| mode.regular).count())
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::{Condition, FrfLine, Position, Quantity};
    use num_complex::Complex64;
    use numeric::random::normal;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Returns a set of six driving points, each with natural frequencies (Hz) and residues of its own.
    fn set(
        random: &mut Xoshiro256PlusPlus,
        mut modes: impl FnMut(&mut Xoshiro256PlusPlus, usize) -> Vec<(f64, f64)>,
    ) -> MeasurementSet {
        let mut set = MeasurementSet::none();
        for at in 0..6 {
            let modes = modes(random, at);
            let mut value = |f: f64| {
                let sum: Complex64 = modes
                    .iter()
                    .map(|(hz, residue)| residue / Complex64::new(hz * hz - f * f, 0.04 * hz * f))
                    .sum();
                sum * (1.0 + 0.01 * Complex64::new(normal(random), normal(random)))
            };
            set.positions.push(Position { name: format!("l{at}"), nut_m: Some(0.2 * at as f64 + 0.2) });
            set.frfs.push(Frf {
                position: Some(at),
                record: None,
                response: "table".into(),
                excitation: "table".into(),
                quantity: Quantity::Receptance,
                condition: Condition::default(),
                averages: None,
                source: format!("l{at}.csv"),
                lines: (10..800)
                    .map(|f| FrfLine { frequency_hz: f64::from(f), value: value(f64::from(f)), noise: None })
                    .collect(),
                rejected: Vec::new(),
            });
        }
        set
    }

    #[test]
    fn limit_records_of_one_passive_machine_are_distinguished() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
        let all: Vec<usize> = (0..6).collect();
        let (rounds, mut found_unlike) = (10, 0);
        for _ in 0..rounds {
            // Modes that move with the nut.
            let moving = |at: usize| {
                vec![(50.0 + at as f64, 1.0), (210.0 - 3.0 * at as f64, 3.0), (540.0 + 8.0 * at as f64, 9.0)]
            };
            assert_eq!(mismatch(&set(&mut random, |_, at| moving(at)), &all), None);
            let unlike = |random: &mut Xoshiro256PlusPlus, _: usize| {
                (0..3)
                    .map(|_| {
                        (15.0 * 50.0_f64.powf(random.random::<f64>()), 0.5 + 2.0 * random.random::<f64>())
                    })
                    .collect()
            };
            found_unlike += usize::from(
                mismatch(&set(&mut random, unlike), &all) == Some(Mismatch::NoRegularMode { records: 6 }),
            );
            let signs = |random: &mut Xoshiro256PlusPlus, at: usize| {
                let mut sign = || if random.random::<bool>() { 1.0 } else { -1.0 };
                moving(at).into_iter().map(|(hz, residue)| (hz, sign() * residue)).collect()
            };
            let found = mismatch(&set(&mut random, signs), &all);
            assert!(matches!(found, Some(Mismatch::ActiveDrivingPoints { .. })), "{found:?}");
        }
        // By chance a few records have modes that look like one.
        assert!(found_unlike + 2 >= rounds, "{found_unlike} of {rounds}");
    }
}
