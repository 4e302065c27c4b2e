//! Nuts of finite length: a nut supports its screw at two places.

use std::f64::consts::TAU;

use super::number::{MARK, massless, of_unstated, size, tolerance};
use crate::{Joint, Machine, Mechanism, Operating, PointMotion, Prior, Shaft, Station, StationPlace, Value};

/// Half the distance between the two supports of a nut: in leads, or in diameters of the screw where the lead
/// is unknown.
///
/// A uniformly distributed load stretches the screw as much as two supports at a third of the nut's length on
/// either side.
///
/// # Source  catalogues of ball nuts: two to four loaded turns; preloaded nuts have two such bodies, two to
///   six turns in all.
const HALF_NUT: (f64, f64) = (0.9, 0.4);
/// Upper limits of that half distance: as a share of the screw's length, and of the distance from a nut to
/// the nearest other station.
const HALF_NUT_MOST: (f64, f64) = (0.05, 0.3);
/// Range of the factor of the nut's length: the length is positive and ends before the next station.
const FACTOR: (f64, f64) = (0.02, 2.4);
/// Range of the offset of the nut's load centre, in half distances.
const MIDDLE: (f64, f64) = (-0.8, 0.8);

/// Standard deviation of the offset of a nut's load centre, in half distances: the balls do not share the
/// load evenly.
///
/// # Source  load of the first turns of a ball nut up to a third above the mean: Mei et al., Mech. Mach.
///   Theory 38 (2003) 1257–1269.
const ASIDE: f64 = 0.2;

/// Distributes the joints at a nut over two supports on its shaft, half each, for nuts at the given positions
/// (m).
///
/// The distance of the supports and the offset of their midpoint are parameters with priors.
pub(super) fn distribute_nut_loads(machine: &mut Machine, nuts_m: &[f64]) {
    let sd = machine.tolerance.nut_length;
    if !(sd > 0.0) {
        return;
    }
    let (mean, sd) = of_unstated(sd);
    for index in 0..machine.shafts.len() {
        let Some(at) = machine.shafts[index].stations.iter().position(|s| s.place == StationPlace::Nut)
        else {
            continue;
        };
        let nut = machine.shafts[index].stations[at];
        let is_at_nut = |joint: &Joint| {
            joint.on.len() > 1
                && joint.on.iter().any(|(p, _)| Some(*p) == nut.axial || Some(*p) == nut.torsion)
        };
        let joints: Vec<usize> =
            (0..machine.joints.len()).filter(|j| is_at_nut(&machine.joints[*j])).collect();
        let half_m = half_nut_m(machine, &machine.shafts[index], at, &joints, nuts_m);
        let Some(half_m) = half_m.filter(|half_m| *half_m > 0.0 && !joints.is_empty()) else { continue };
        machine.shafts[index].nut_support_factor = Value::parameter(machine.parameters.len());
        let name = format!("nut length on {}", machine.shafts[index].name);
        machine.parameters.push(tolerance(
            name,
            (Mechanism::Ratio, "1"),
            (mean, Prior::Normal(sd)),
            [FACTOR.0, FACTOR.1],
        ));
        machine.shafts[index].nut_support_offset = Value::parameter(machine.parameters.len());
        let name = format!("nut load on {}", machine.shafts[index].name);
        machine.parameters.push(tolerance(
            name,
            (Mechanism::Ratio, "1"),
            (0.0, Prior::Normal(ASIDE)),
            [MIDDLE.0, MIDDLE.1],
        ));
        let [before, after] = [("before", -half_m), ("after", half_m)].map(|(side, offset_m)| {
            let name = format!("{MARK}nut {index} {side}");
            let axial = nut.axial.map(|_| massless(machine, &name, PointMotion::Translation));
            let torsion = nut.torsion.map(|_| massless(machine, &name, PointMotion::Rotation));
            Station { place: StationPlace::NearNut(offset_m), axial, torsion }
        });
        // Two joints of one name: a stiff nut also bridges the screw between its supports.
        for joint in joints {
            let halves = [before, after].map(|there| {
                let mut half = machine.joints[joint].clone();
                half.share *= 0.5;
                for (point, coefficient) in &mut half.on {
                    *coefficient *= 0.5_f64.sqrt();
                    for (own, support) in [(nut.axial, there.axial), (nut.torsion, there.torsion)] {
                        if let Some(support) = support.filter(|_| own == Some(*point)) {
                            *point = support;
                        }
                    }
                }
                half
            });
            let [first, second] = halves;
            machine.joints[joint] = first;
            machine.joints.push(second);
        }
        machine.shafts[index].stations.splice(at..=at, [before, nut, after]);
    }
}

/// Computes half the distance (m) between the two supports of a nut; `None` for a nut at an end of the shaft.
fn half_nut_m(machine: &Machine, shaft: &Shaft, at: usize, joints: &[usize], nuts_m: &[f64]) -> Option<f64> {
    let nut = shaft.stations[at];
    let coefficient = |joint: &Joint, point: Option<usize>| {
        joint.on.iter().find(|(p, _)| Some(*p) == point).map(|(_, c)| *c)
    };
    let lead_of =
        |joint: &Joint| Some(TAU * (coefficient(joint, nut.torsion)? / coefficient(joint, nut.axial)?).abs());
    let lead_m = joints.iter().find_map(|j| lead_of(&machine.joints[*j]));
    let length_m = size(&shaft.length, machine);
    let typical_m = lead_m.map_or(HALF_NUT.1 * size(&shaft.diameter, machine), |lead_m| HALF_NUT.0 * lead_m);
    // A nut lies between other stations; nut positions elsewhere are rejected with their records.
    let (before, after) = (shaft.stations.get(at.checked_sub(1)?)?, shaft.stations.get(at + 1)?);
    let place_m = |station: &Station| shaft.place_m(station.place, &machine.start(), &Operating::default());
    let (low_m, high_m) = (place_m(before).unwrap_or(0.0), place_m(after).unwrap_or(length_m));
    let inside = nuts_m.iter().filter(|x| (low_m..high_m).contains(*x));
    let free_m = inside.map(|x| (x - low_m).min(high_m - x)).fold(0.5 * length_m, f64::min);
    Some(typical_m.min(HALF_NUT_MOST.0 * length_m).min(HALF_NUT_MOST.1 * free_m))
}
