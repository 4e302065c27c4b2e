//! What every machine has beside its description: a nut that holds its screw over a length, and journals thinner than the screw.

use std::f64::consts::TAU;

use rand::{Rng, RngExt};

use super::hypothesis::nuisance_parameter;
use machine::{FitRule, Joint, Law, Machine, Motion, Operating, Parameter, Place, Point, Scale, Shaft, Station, Tolerance, Value};
use numeric::random::normal;

/// Half the distance of the two places at which a nut is taken to hold its screw, in leads: a load spread evenly stretches the screw as one at two places a third
/// of its length to either side does. Of a nut whose lead is not told, in diameters of the screw.
///
/// # Source  catalogues of ball nuts: two to four loaded turns, preloaded ones in two bodies of so many.
const HALF_NUT: (f64, f64) = (1.2, 0.5);
/// The same at most, of the screw's length, and of the distance of a nut to the nearest other station.
const HALF_NUT_MOST: (f64, f64) = (0.05, 0.35);
/// Standard deviation of its factor, and the ends of that.
const HALF_NUT_FACTOR: (f64, [f64; 2]) = (0.35, [0.02, 2.0]);
/// Length of a journal in diameters of the screw, and by how much thinner it is.
///
/// # Source  catalogues of machined screw ends: bearing seats of 0.85 to 0.95 of the screw's diameter, with collar and nut one to two and a half long.
const JOURNAL: ([f64; 2], [f64; 2]) = ([1.0, 2.5], [0.05, 0.15]);
/// A journal at most, of the screw's length.
const JOURNAL_MOST: f64 = 0.1;
/// How far the middle of a nut's load may lie from its own, in half lengths.
const ASIDE: f64 = 0.3;

fn size(value: &Value, machine: &Machine) -> f64 {
    value.at(&machine.start(), &Operating::default())
}

/// Standard deviation of what a journal takes from the inertia of a shaft, as a share of it: some diameters' length of the whole section.
pub(super) fn journal_share(machine: &Machine, shaft: &Shaft) -> f64 {
    (machine.tolerance.end_diameters * size(&shaft.diameter, machine) / size(&shaft.length, machine)).min(JOURNAL_MOST)
}

/// Lets joints at a nut hold their shaft at two places beside it, half each, for nuts that stand at given places (m): how far apart is a
/// nuisance.
pub(super) fn hold_over_length(machine: &mut Machine, nuts_m: &[f64]) {
    for index in 0..machine.shafts.len() {
        let Some(at) = machine.shafts[index].stations.iter().position(|s| s.place == Place::Nut) else { continue };
        let nut = machine.shafts[index].stations[at];
        let is_at_nut =
            |joint: &Joint| joint.on.len() > 1 && joint.on.iter().any(|(p, _)| Some(*p) == nut.axial || Some(*p) == nut.torsion);
        let joints: Vec<usize> = (0..machine.joints.len()).filter(|j| is_at_nut(&machine.joints[*j])).collect();
        let half_m = half_nut_m(machine, &machine.shafts[index], at, &joints, nuts_m);
        let Some(half_m) = half_m.filter(|half_m| *half_m > 0.0 && !joints.is_empty()) else { continue };
        machine.shafts[index].beside_nut = Value::parameter(machine.parameters.len());
        let (sd, [lower, upper]) = HALF_NUT_FACTOR;
        let parameter = nuisance_parameter(format!("~nut {}", machine.shafts[index].name), 1.0, sd);
        machine.parameters.push(Parameter { lower, upper, ..parameter });
        let [before, after] = [("before", -half_m), ("after", half_m)].map(|(side, offset_m)| {
            let axial = nut.axial.map(|_| massless(machine, format!("~nut {index} {side} axial"), Motion::Translation));
            let torsion = nut.torsion.map(|_| massless(machine, format!("~nut {index} {side} torsion"), Motion::Rotation));
            Station { place: Place::BesideNut(offset_m), axial, torsion }
        });
        let both = |point: Option<usize>, points: [Option<usize>; 2]| Some((point?, [points[0]?, points[1]?]));
        let moved = [both(nut.axial, [before.axial, after.axial]), both(nut.torsion, [before.torsion, after.torsion])];
        for joint in joints {
            for (point, beside) in moved.into_iter().flatten() {
                let on = &mut machine.joints[joint].on;
                if let Some(place) = on.iter().position(|(p, _)| *p == point) {
                    let half = 0.5 * on[place].1;
                    on.splice(place..=place, beside.map(|p| (p, half)));
                }
            }
        }
        machine.shafts[index].stations.splice(at..=at, [before, nut, after]);
    }
}

/// Half the distance (m) of the two places at which a nut, a station of a shaft with joints, holds it; `None` at an end of the shaft.
fn half_nut_m(machine: &Machine, shaft: &Shaft, at: usize, joints: &[usize], nuts_m: &[f64]) -> Option<f64> {
    let nut = shaft.stations[at];
    let coefficient = |joint: &Joint, point: Option<usize>| joint.on.iter().find(|(p, _)| Some(*p) == point).map(|(_, c)| *c);
    let lead_of = |joint: &Joint| Some(TAU * (coefficient(joint, nut.torsion)? / coefficient(joint, nut.axial)?).abs());
    let lead_m = joints.iter().find_map(|j| lead_of(&machine.joints[*j]));
    let length_m = size(&shaft.length, machine);
    let usual_m = lead_m.map_or(HALF_NUT.1 * size(&shaft.diameter, machine), |lead_m| HALF_NUT.0 * lead_m);
    // A nut stands between other stations; where one of the set does not, its record is refused elsewhere.
    let (before, after) = (shaft.stations.get(at.checked_sub(1)?)?, shaft.stations.get(at + 1)?);
    let place_m = |station: &Station| shaft.place_m(station.place, &machine.start(), &Operating::default());
    let (low_m, high_m) = (place_m(before).unwrap_or(0.0), place_m(after).unwrap_or(length_m));
    let inside = nuts_m.iter().filter(|x| (low_m..high_m).contains(*x));
    let free_m = inside.map(|x| (x - low_m).min(high_m - x)).fold(0.5 * length_m, f64::min);
    Some(usual_m.min(HALF_NUT_MOST.0 * length_m).min(HALF_NUT_MOST.1 * free_m))
}

/// A value of a nuisance by what is known of it beforehand; `None` for a parameter of which nothing is.
pub fn drawn(nuisance: &Parameter, random: &mut impl Rng) -> Option<f64> {
    let sd = nuisance.sd?;
    // What ends of shafts weigh less by is [`another`]'s to say.
    let ends = nuisance.id.starts_with("~end");
    let value = nuisance.start + if ends { 0.0 } else { sd * normal(random) };
    // A loss is never below nothing: it is mirrored there.
    let value = if nuisance.lower >= 0.0 { value.abs() } else { value };
    Some(value.clamp(nuisance.lower, nuisance.upper))
}

/// The machine with journals at the ends of its shafts, and nuts whose load lies off their middle.
pub fn another(machine: &Machine, random: &mut impl Rng) -> Machine {
    let mut richer = machine.clone();
    // Journals of which more is known than usual are shorter than usual.
    let known = machine.tolerance.end_diameters / Tolerance::default().end_diameters;
    let mut between = |[low, high]: [f64; 2]| random.random_range(low..high);
    for index in 0..machine.shafts.len() {
        let shaft = &machine.shafts[index];
        let (length_m, diameter_m) = (size(&shaft.length, machine), size(&shaft.diameter, machine));
        let aside = between([-ASIDE, ASIDE]);
        for station in &mut richer.shafts[index].stations {
            if let Place::BesideNut(offset_m) = &mut station.place {
                *offset_m += aside * offset_m.abs();
            }
        }
        for right in [false, true] {
            let journal_m = (known * diameter_m * between(JOURNAL.0)).min(JOURNAL_MOST * length_m);
            let thinner = between(JOURNAL.1);
            journal(&mut richer, index, right, (length_m, journal_m), thinner);
        }
    }
    richer
}

fn massless(machine: &mut Machine, name: String, motion: Motion) -> usize {
    machine.points.push(Point { name, motion, inertia: Value::number(0.0), fixed: false });
    machine.points.len() - 1
}

/// A fixed number as a parameter, so that a law can refer to it.
fn constant(machine: &mut Machine, id: String, number: f64) -> usize {
    let (lower, upper) = (number - 1.0, number + 1.0);
    let (unit, source) = ("1".into(), String::new());
    machine.parameters.push(Parameter {
        id,
        unit,
        start: number,
        lower,
        upper,
        scale: Scale::Linear,
        fit: FitRule::Never,
        sd: None,
        source,
    });
    machine.parameters.len() - 1
}

/// Cuts the end of a shaft off as a shaft of its own, thinner.
fn journal(machine: &mut Machine, index: usize, right: bool, (length_m, journal_m): (f64, f64), thinner: f64) {
    let shaft = machine.shafts[index].clone();
    let Some(end) = (if right { shaft.stations.last() } else { shaft.stations.first() }).copied() else { return };
    let at = Place::At(if right { length_m - journal_m } else { journal_m });
    let name = format!("~journal {index} {right}");
    let axial = end.axial.map(|_| massless(machine, format!("{name} axial"), Motion::Translation));
    let torsion = end.torsion.map(|_| massless(machine, format!("{name} torsion"), Motion::Rotation));
    let seam = Station { place: at, axial, torsion };
    let mut own = shaft;
    let by = constant(machine, name.clone(), 1.0 - thinner);
    own.diameter.laws.push(Law::Times(by));
    own.name = name;
    own.stations = if right { vec![seam, end] } else { vec![end, seam] };
    let stations = &mut machine.shafts[index].stations;
    if let Some(station) = if right { stations.last_mut() } else { stations.first_mut() } {
        *station = seam;
    }
    machine.shafts.push(own);
}
