//! Tolerances as parameters.

use crate::point::Point;
use crate::{FitRule, Machine, Mechanism, Operating, Parameter, PointMotion, Prior, Role, Scale, Value};

/// Numerical bound of a tolerance, in standard deviations: wide enough not to constrain the fit.
pub(super) const STOP: f64 = 20.0;
/// Smallest loss factor over its median (1): 0.95 of the deviation of a joint without loss, and with 0.05 % of
/// stiffness out of phase as good as none beside a damping ratio of 1 %. Half of it gains 0.025 of that deviation.
const LEAST_LOSS: f64 = 0.05;
/// Numerical bound of a relative change: a number keeps at least half of its value.
pub(super) const RELATIVE_STOP: f64 = 0.5;
/// Begins the ids of tolerances and the names of their parts, which keeps them distinct from those of a
/// description. Nothing is decided by it: see
/// [`Role`].
pub(super) const MARK: char = '~';

/// Creates a tolerance: its name, its mechanism and unit, its start value with the prior, and its range.
pub(super) fn tolerance(
    name: String,
    (mechanism, unit): (Mechanism, &str),
    (start, prior): (f64, Prior),
    [lower, upper]: [f64; 2],
) -> Parameter {
    let scale = if matches!(prior, Prior::LogNormal(_)) { Scale::Logarithmic } else { Scale::Linear };
    Parameter {
        id: format!("{MARK}{name}"),
        unit: unit.into(),
        mechanism,
        role: Role::Tolerance,
        start,
        lower,
        upper,
        scale,
        fit: FitRule::Always,
        prior: Some(prior),
        source: "tolerance of the description".into(),
        description: String::new(),
    }
}

/// Creates a tolerance for the relative change of a number.
pub(super) fn relative(name: String, sd: f64) -> Parameter {
    let stop = (STOP * sd).min(RELATIVE_STOP);
    tolerance(name, (Mechanism::Ratio, "1"), (0.0, Prior::Normal(sd)), [-stop, stop])
}

/// Creates a tolerance for a loss factor around a median.
pub(super) fn loss(name: String, median: f64, spread: f64) -> Parameter {
    let stop = (STOP * spread).min(7.0).exp();
    tolerance(
        name,
        (Mechanism::LossFactor, "1"),
        (median, Prior::LogNormal(spread)),
        [median * LEAST_LOSS, median * stop],
    )
}

/// Returns mean and standard deviation of a feature that a description may leave out, over its typical size,
/// which it has to a relative standard deviation: it is there or not at equal odds, as a machine may be described
/// with or without it.
pub(super) fn of_unstated(sd: f64) -> (f64, f64) {
    const ODDS: f64 = 0.5;
    (ODDS, (ODDS * sd * sd + ODDS * (1.0 - ODDS)).sqrt())
}

/// Returns a number at the start values.
pub(super) fn size(value: &Value, machine: &Machine) -> f64 {
    value.at(&machine.start(), &Operating::default())
}

/// Adds a massless point for a station of a shaft and returns its index; the name begins with [`MARK`].
pub(super) fn massless(machine: &mut Machine, name: &str, motion: PointMotion) -> usize {
    let name = format!("{name} {}", motion.noun());
    machine.points.push(Point {
        name,
        motion,
        inertia: Value::number(0.0),
        fixed: false,
        role: Role::Tolerance,
    });
    machine.points.len() - 1
}
