//! Random discrepancies between a machine and its description: tolerances drawn from their priors, and
//! lengths of journals, which no parameter describes.

use rand::{Rng, RngExt};

use machine::{Machine, Operating, Parameter, Prior, StationPlace};
use numeric::random::normal;

/// Range of the true journal length over the modelled one (1): 1 to 2.5 diameters against 1.75 diameters, the
/// length that `machine::tolerance::journal` models.
///
/// # Source  catalogues of machined screw ends: bearing seats with shoulder and lock nut are 1 to 2.5
///   diameters long.
const JOURNAL_LENGTH_RATIO: (f64, f64) = (1.0 / 1.75, 2.5 / 1.75);

/// Draws a tolerance from its prior, within its range. Returns `None` for a parameter without a prior.
pub fn sample_prior(tolerance: &Parameter, generator: &mut impl Rng) -> Option<f64> {
    let prior = tolerance.prior?;
    let deviation = normal(generator);
    // A normal prior whose range begins at its mean is half-normal.
    let half = matches!(prior, Prior::Normal(_)) && tolerance.lower >= tolerance.start;
    let deviation = if half { deviation.abs() } else { deviation };
    Some(prior.value(tolerance.start, deviation).clamp(tolerance.lower, tolerance.upper))
}

/// Returns the machine with random lengths of the journals at the ends of its shafts, uniform over their
/// range.
pub fn sample_discrepancy(machine: &Machine, generator: &mut impl Rng) -> Machine {
    let journals = (0..machine.shafts.len()).filter(|shaft| machine.shafts[*shaft].is_journal());
    let (least, largest) = JOURNAL_LENGTH_RATIO;
    journals.fold(machine.clone(), |perturbed, shaft| {
        with_journal(machine, perturbed, shaft, generator.random_range(least..largest))
    })
}

/// Returns the machines with the least and the largest length of each journal, all others as described.
pub(super) fn extreme_discrepancies(machine: &Machine) -> Vec<[Machine; 2]> {
    let journals = (0..machine.shafts.len()).filter(|shaft| machine.shafts[*shaft].is_journal());
    let (least, largest) = JOURNAL_LENGTH_RATIO;
    journals
        .map(|shaft| [least, largest].map(|ratio| with_journal(machine, machine.clone(), shaft, ratio)))
        .collect()
}

/// Changes the length of a journal of the described machine by a ratio. The shaft and its journal share the
/// junction: it moves in both.
fn with_journal(machine: &Machine, mut perturbed: Machine, shaft: usize, ratio: f64) -> Machine {
    let shaft = &machine.shafts[shaft];
    let length_m = shaft.length.at(&machine.start(), &Operating::default());
    // The junction of journal and shaft is the station that is not an end of the whole shaft.
    let is_end = |place: StationPlace| matches!(place, StationPlace::End) || place == StationPlace::At(0.0);
    let Some(junction) = shaft.stations.iter().find(|s| !is_end(s.place)).copied() else { return perturbed };
    let StationPlace::At(at_m) = junction.place else { return perturbed };
    let moved_m = if at_m < 0.5 * length_m { at_m * ratio } else { length_m - (length_m - at_m) * ratio };
    let is_junction = |s: &&mut machine::Station| {
        s.place == junction.place && s.axial == junction.axial && s.torsion == junction.torsion
    };
    perturbed
        .shafts
        .iter_mut()
        .flat_map(|s| &mut s.stations)
        .filter(is_junction)
        .for_each(|s| s.place = StationPlace::At(moved_m));
    perturbed
}
