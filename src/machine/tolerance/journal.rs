//! Journals: the thinner ends of a shaft.

use super::number::{MARK, RELATIVE_STOP, massless, of_unstated, size, tolerance};
use crate::{Machine, Mechanism, Modifier, PointMotion, Prior, Station, StationPlace};

/// Length of a journal in diameters of its shaft.
///
/// # Source  catalogues of machined screw ends: bearing seats of 0.85 to 0.95 of the screw's diameter, 1 to
///   2.5 diameters long with collar
/// and nut.
const DIAMETERS: f64 = 1.75;
/// Relative standard deviation of the section that an end with a journal lacks (1).
const SPREAD: f64 = 0.5;
/// Upper limits of a journal's length: as a share of the shaft's length, and of the distance from the end to
/// the nearest nut or station.
const MOST: (f64, f64) = (0.1, 0.5);

/// Separates the ends of all shafts as journals: shafts of their own with a smaller diameter, whose relative
/// change has a prior.
pub(super) fn split_off_journals(machine: &mut Machine, nuts_m: &[f64]) {
    let missing_diameters = machine.tolerance.end_diameters;
    if !(missing_diameters > 0.0) {
        return;
    }
    for index in 0..machine.shafts.len() {
        let shaft = &machine.shafts[index];
        // A shaft whose length is a parameter keeps its ends.
        if shaft.length.depends_on().next().is_some() || shaft.stations.len() < 2 {
            continue;
        }
        let (length_m, diameter_m) = (size(&shaft.length, machine), size(&shaft.diameter, machine));
        for right in [false, true] {
            let shaft = &machine.shafts[index];
            let Some(end) = (if right { shaft.stations.last() } else { shaft.stations.first() }).copied()
            else {
                continue;
            };
            if end.place != (if right { StationPlace::End } else { StationPlace::At(0.0) }) {
                continue;
            }
            let from_end = |x: f64| if right { length_m - x } else { x };
            let nearest_m = nuts_m.iter().map(|x| from_end(*x)).filter(|x| *x > 0.0).fold(length_m, f64::min);
            let others_m = shaft
                .stations
                .iter()
                .filter_map(|s| if let StationPlace::At(x) = s.place { Some(from_end(x)) } else { None });
            let nearest_m = others_m.filter(|x| *x > 0.0).fold(nearest_m, f64::min);
            let journal_m = (DIAMETERS * diameter_m).min(MOST.0 * length_m).min(MOST.1 * nearest_m);
            // To first order a section loses twice the relative loss of its diameter.
            let thinner = (0.5 * missing_diameters * diameter_m / journal_m).min(0.8 * RELATIVE_STOP);
            let name = machine
                .points
                .get(end.axial.or(end.torsion).unwrap_or(usize::MAX))
                .map_or_else(String::new, |p| p.name.clone());
            let (mean, sd) = of_unstated(SPREAD);
            let prior = (-mean * thinner, Prior::Normal(sd * thinner));
            let parameter = tolerance(
                format!("journal at {name}"),
                (Mechanism::Ratio, "1"),
                prior,
                [-RELATIVE_STOP, RELATIVE_STOP],
            );
            machine.parameters.push(parameter);
            split_off(
                machine,
                index,
                right,
                from_end(journal_m),
                Modifier::Relative(machine.parameters.len() - 1),
            );
        }
    }
}

/// Separates the end of a shaft at a place (m) as a shaft of its own with a modified diameter.
fn split_off(machine: &mut Machine, index: usize, right: bool, at_m: f64, thinner: Modifier) {
    let shaft = machine.shafts[index].clone();
    let (first, last) = (shaft.stations[0], shaft.stations[shaft.stations.len() - 1]);
    let end = if right { last } else { first };
    let name = format!("{MARK}journal {} of {}", if right { "right" } else { "left" }, shaft.name);
    let axial = end.axial.map(|_| massless(machine, &name, PointMotion::Translation));
    let torsion = end.torsion.map(|_| massless(machine, &name, PointMotion::Rotation));
    let junction = Station { place: StationPlace::At(at_m), axial, torsion };
    let mut journal = shaft;
    journal.diameter.modifiers.push(thinner);
    journal.journal_of = Some(std::mem::replace(&mut journal.name, name));
    // The shaft bends as a whole, over its own stations and those of its journals.
    journal.bending = None;
    journal.stations = if right { vec![junction, end] } else { vec![end, junction] };
    let stations = &mut machine.shafts[index].stations;
    let place = if right { stations.len() - 1 } else { 0 };
    stations[place] = junction;
    machine.shafts.push(journal);
}
