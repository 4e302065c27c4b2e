//! Tolerances as parameters.

use crate::point::Point;
use crate::{FitRule, Machine, Operating, Parameter, PointMotion, Prior, Scale, Value};

/// Numerical bound of a tolerance, in standard deviations: wide enough not to constrain the fit.
pub(super) const STOP: f64 = 20.0;
/// Numerical bound of a relative change: a number keeps at least half of its value.
pub(super) const RELATIVE_STOP: f64 = 0.5;
/// First letter of the ids of tolerances, which a description cannot use.
pub(super) const MARK: char = '~';

pub(super) fn tolerance(name: String, unit: &str, (start, prior): (f64, Prior), [lower, upper]: [f64; 2]) -> Parameter {
    let scale = if matches!(prior, Prior::LogNormal(_)) { Scale::Logarithmic } else { Scale::Linear };
    Parameter {
        id: format!("{MARK}{name}"),
        unit: unit.into(),
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
    tolerance(name, "1", (0.0, Prior::Normal(sd)), [-stop, stop])
}

/// Creates a tolerance for a loss factor around a median.
pub(super) fn loss(name: String, median: f64, spread: f64) -> Parameter {
    let stop = (STOP * spread).min(7.0).exp();
    tolerance(name, "1", (median, Prior::LogNormal(spread)), [median / stop, median * stop])
}

/// Returns a number at the start values.
pub(super) fn size(value: &Value, machine: &Machine) -> f64 {
    value.at(&machine.start(), &Operating::default())
}

/// Adds a massless point for a station of a shaft and returns its index.
pub(super) fn massless(machine: &mut Machine, name: &str, motion: PointMotion) -> usize {
    let name = format!("{name} {}", motion.noun());
    machine.points.push(Point { name, motion, inertia: Value::number(0.0), fixed: false });
    machine.points.len() - 1
}
