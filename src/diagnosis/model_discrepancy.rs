//! Random discrepancies between a machine and its description: tolerances drawn from their priors, and details that no parameter describes.

use rand::{Rng, RngExt};

use machine::{Machine, Operating, Parameter, Prior, StationPlace};
use numeric::random::normal;

/// Least and largest length of a journal over that assumed by the tolerances.
///
/// # Source  catalogues of machined screw ends: bearing seats with collar and nut are 1 to 2.5 diameters long, 1.75 on average.
const JOURNAL: (f64, f64) = (1.0 / 1.75, 2.5 / 1.75);

/// Draws a tolerance from its prior; `None` for a parameter without a prior.
pub fn sample_prior(tolerance: &Parameter, random: &mut impl Rng) -> Option<f64> {
    let prior = tolerance.prior?;
    let deviation = normal(random);
    // A normal prior whose range begins at its mean is a half-normal one.
    let half = matches!(prior, Prior::Normal(_)) && tolerance.lower >= tolerance.start;
    let deviation = if half { deviation.abs() } else { deviation };
    Some(prior.value(tolerance.start, deviation).clamp(tolerance.lower, tolerance.upper))
}

/// Returns the machine with random lengths of the journals at the ends of its shafts.
pub fn sample_discrepancy(machine: &Machine, random: &mut impl Rng) -> Machine {
    let mut other = machine.clone();
    let mut between = |low: f64, high: f64| random.random_range(low..high);
    for index in (0..machine.shafts.len()).filter(|index| machine.shafts[*index].is_journal()) {
        let shaft = &machine.shafts[index];
        let length_m = shaft.length.at(&machine.start(), &Operating::default());
        // The seam of a journal is the station that is not an end of the whole shaft.
        let Some(seam) = shaft.stations.iter().find(|s| !matches!(s.place, StationPlace::End) && s.place != StationPlace::At(0.0)).copied()
        else {
            continue;
        };
        let StationPlace::At(at_m) = seam.place else { continue };
        let times = between(JOURNAL.0, JOURNAL.1);
        let there_m = if at_m < 0.5 * length_m { at_m * times } else { length_m - (length_m - at_m) * times };
        let same = |s: &&mut machine::Station| s.place == seam.place && s.axial == seam.axial && s.torsion == seam.torsion;
        other.shafts.iter_mut().flat_map(|s| &mut s.stations).filter(same).for_each(|s| s.place = StationPlace::At(there_m));
    }
    other
}
