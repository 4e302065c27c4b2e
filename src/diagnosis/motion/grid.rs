//! Grid of trial values of the parameters in which the force is not linear.

use super::data::MotionData;
use dynamics::inverse_dynamics::{Rigid, prediction};
use machine::{Machine, Mechanism, Parameter, PeriodAlong, PointMotion, Scale};
use numeric::halton::halton_point;
use numeric::statistics::extremes;

/// A parameter (by index) in which the force, or whose inverse it, is linear.
#[derive(Clone, Copy)]
pub(super) struct LinearParameter {
    pub index: usize,
    pub inverse: bool,
    /// Whether its derivative is a difference quotient between two values.
    pub chord: bool,
}

impl LinearParameter {
    /// Converts between value and linear coefficient, in either direction.
    pub fn of(self, x: f64) -> f64 {
        if self.inverse { 1.0 / x } else { x }
    }

    /// Returns its bounds as a coefficient.
    pub fn ends(self, parameter: &Parameter) -> (f64, f64) {
        let (a, b) = (self.of(parameter.lower), self.of(parameter.upper));
        (a.min(b), a.max(b))
    }

    /// Returns the value without influence, or the closest to it.
    pub fn without_influence(self, parameter: &Parameter) -> f64 {
        if self.inverse { parameter.upper } else { 0.0_f64.clamp(parameter.lower, parameter.upper) }
    }
}

/// Grid nodes over one nonlinear parameter; largest number of waves over the travel, with two nodes each;
/// nodes over several parameters.
const NODES: (usize, usize, usize) = (24, 80, 48);

/// Returns the travel that holds the longest wave of a period, in its unit; `None` for another parameter.
pub(super) fn longest_wave(
    machine: &Machine,
    parameter: &Parameter,
    data: &MotionData<'_>,
    rigid: &Rigid,
) -> Option<f64> {
    let turning = || {
        let on = machine.drive.as_ref().map(|d| d.on);
        on.filter(|p| machine.points[*p].motion == PointMotion::Rotation)
    };
    let ratio = match parameter.mechanism {
        Mechanism::Period(PeriodAlong::Travel) => 1.0,
        Mechanism::Period(PeriodAlong::Motor) => {
            turning().map_or(1.0, |point| rigid.point_ratio(point).abs())
        }
        _ => return None,
    };
    let (low, high) = extremes(data.motions.iter().flat_map(|m| &m.position_m));
    Some(ratio * (high - low))
}

/// Returns the grid nodes over the ranges of nonlinear parameters. A period is searched from an eightieth of
/// the travel to the travel, at nodes half a wave apart over it. Longer waves belong to the nuisance
/// parameters.
pub(super) fn grid(
    machine: &Machine,
    curved: &[usize],
    data: &MotionData<'_>,
    rigid: &Rigid,
) -> Vec<Vec<(usize, f64)>> {
    let range = |index: usize| {
        let p = &machine.parameters[index];
        match longest_wave(machine, p, data, rigid) {
            Some(travel) => (p.lower.max(travel / NODES.1 as f64), p.upper.min(travel), true),
            None => (p.lower, p.upper, p.scale == Scale::Logarithmic),
        }
    };
    let value = |index: usize, unit: f64| {
        let (low, high, logarithmic) = range(index);
        if logarithmic && low > 0.0 { low * (high / low).powf(unit) } else { low + unit * (high - low) }
    };
    match curved {
        [] => vec![Vec::new()],
        [one] => {
            if machine.parameters[*one].mechanism.is_period() {
                let (low, high, _) = range(*one);
                let count = (2.0 * high / low).clamp(1.0, 2.0 * NODES.1 as f64) as usize;
                let waves =
                    |k: usize| 1.0 / high + (k as f64 + 0.5) / count as f64 * (1.0 / low - 1.0 / high);
                return (0..count).map(|k| vec![(*one, 1.0 / waves(k))]).collect();
            }
            let count = NODES.0;
            // From the inner neighbour of the end with next to no influence outward: that end itself has no
            // information. A range that begins at zero is divided by the third power: nodes are denser at
            // small values.
            let (low, _, logarithmic) = range(*one);
            let unit = |k: usize| {
                ((k as f64 - 0.5) / count as f64).powi(if low == 0.0 && !logarithmic { 3 } else { 1 })
            };
            (1..=count).map(|k| vec![(*one, value(*one, unit(k)))]).collect()
        }
        several => {
            let point = |k: usize| {
                several
                    .iter()
                    .zip(halton_point(k, several.len()))
                    .map(|(i, unit)| (*i, value(*i, unit)))
                    .collect()
            };
            (1..=NODES.2).map(point).collect()
        }
    }
}

/// Share of the force that a small amplitude changes.
const SMALL_CHANGE: f64 = 0.05;

/// Returns a small value of an amplitude; `None` for other parameters.
pub(super) fn small(
    rigid: &Rigid,
    machine: &Machine,
    start: &[f64],
    index: usize,
    data: &MotionData<'_>,
) -> Option<f64> {
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
    Some((SMALL_CHANGE * none.norm() * first / (force(first) - &none).norm()).min(most))
}
