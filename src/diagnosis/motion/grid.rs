//! Where candidates are tried: places over the ranges of what the force is not linear in.

use super::data::MotionData;
use dynamics::inverse_dynamics::{Rigid, prediction};
use machine::{Machine, PointMotion, Scale};
use numeric::halton::halton_point;
use numeric::statistics::extremes;

/// Places of a lattice over one number that is not linear; most waves to the travel, two places each; places over several numbers.
const PLACES: (usize, usize, usize) = (24, 80, 48);

/// Places over the ranges of parameters that are not linear. A period is looked for from an eightieth of the travel to the travel, at places half a wave
/// apart over it: longer waves are what ordinarily varies along it.
pub(super) fn grid(machine: &Machine, curved: &[usize], data: &MotionData<'_>, rigid: &Rigid) -> Vec<Vec<(usize, f64)>> {
    let turning = machine.drive.as_ref().map(|d| d.on).filter(|p| machine.points[*p].motion == PointMotion::Rotation);
    let range = |index: usize| {
        let p = &machine.parameters[index];
        let period = p.id.ends_with("period");
        let (low, high) = extremes(data.motions.iter().flat_map(|m| &m.position_m));
        let travel = turning.filter(|_| p.unit.contains("rad")).map_or(1.0, |point| rigid.point_ratio(point).abs());
        let (low, high) = (travel * low, travel * high);
        if period && p.unit.contains('m') {
            (p.lower.max((high - low) / PLACES.1 as f64), p.upper.min(high - low), true)
        } else {
            (p.lower, p.upper, p.scale == Scale::Logarithmic)
        }
    };
    let value = |index: usize, unit: f64| {
        let (low, high, logarithmic) = range(index);
        if logarithmic && low > 0.0 { low * (high / low).powf(unit) } else { low + unit * (high - low) }
    };
    match curved {
        [] => vec![Vec::new()],
        [one] => {
            let period = machine.parameters[*one].id.ends_with("period");
            if period {
                let (low, high, _) = range(*one);
                let count = (2.0 * high / low).clamp(1.0, 2.0 * PLACES.1 as f64) as usize;
                let waves = |k: usize| 1.0 / high + (k as f64 + 0.5) / count as f64 * (1.0 / low - 1.0 / high);
                return (0..count).map(|k| vec![(*one, 1.0 / waves(k))]).collect();
            }
            let count = PLACES.0;
            // From the end where it does next to nothing outward; that end itself says nothing.
            // A size that begins at nothing is told by its share: closer together where it is small.
            let (low, _, logarithmic) = range(*one);
            let unit = |k: usize| ((k as f64 - 0.5) / count as f64).powi(if low == 0.0 && !logarithmic { 2 } else { 1 });
            (1..=count).map(|k| vec![(*one, value(*one, unit(k)))]).collect()
        }
        several => {
            let point = |k: usize| several.iter().zip(halton_point(k, several.len())).map(|(i, unit)| (*i, value(*i, unit))).collect();
            (1..=PLACES.2).map(point).collect()
        }
    }
}

/// Share of the force that a small amplitude moves.
const SMALL: f64 = 0.05;

/// A small value of an amplitude; `None` where a parameter is none.
pub(super) fn small(rigid: &Rigid, machine: &Machine, start: &[f64], index: usize, data: &MotionData<'_>) -> Option<f64> {
    let parameter = &machine.parameters[index];
    if parameter.scale == Scale::Logarithmic || !(parameter.lower < 0.0 && 0.0 < parameter.upper) {
        return None;
    }
    let force = |x: f64| {
        let mut values = start.to_vec();
        values[index] = x;
        prediction(rigid, machine, &values, &data.motions)
    };
    let (none, most) = (force(0.0), parameter.upper.min(-parameter.lower));
    let first = 1e-2 * most;
    Some((SMALL * none.norm() * first / (force(first) - &none).norm()).min(most))
}
