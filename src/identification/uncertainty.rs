//! Standard deviations and correlations of the parameters, and when a parameter is identifiable.

use nalgebra::DMatrix;

use machine::{Parameter, Scale};

/// An identified parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Index in the machine.
    pub parameter: usize,
    /// Value in its unit.
    pub value: f64,
    /// 95 % interval; the hull of its parts where it has several; `None` where none was computed.
    pub interval95: Option<(f64, f64)>,
    /// The parts of the 95 % interval in rising order: one for each range of values that the data do not
    /// reject.
    pub intervals95: Vec<(f64, f64)>,
    /// Whether it is identifiable from the data: its interval is narrow, and it does not lie at a bound.
    /// `None` for a parameter that was not fitted, and for one that depends on a doubt.
    pub identifiable: Option<bool>,
    /// Whether it would be identifiable, but for doubts about the fit: it depends on what they name.
    pub depends: bool,
    /// Whether it lies at an end of its plausible range.
    pub at_bound: bool,
}

impl Estimate {
    /// Returns the estimate of a parameter without an interval: one that was not fitted or, with
    /// `identifiable`, one that the data do not determine.
    pub fn without_interval(parameter: usize, value: f64, identifiable: Option<bool>) -> Self {
        let (interval95, intervals95) = (None, Vec::new());
        Estimate { parameter, value, interval95, intervals95, identifiable, depends: false, at_bound: false }
    }

    /// Notes doubts about the fit: an identifiable parameter then depends on what they name.
    pub(crate) fn doubt(&mut self) {
        if self.identifiable == Some(true) {
            (self.identifiable, self.depends) = (None, true);
        }
    }
}

/// Linearised uncertainty of the free parameters about the best fit, in their unit intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct Certainty {
    /// Standard deviation of each coordinate in its unit interval.
    pub sd: Vec<f64>,
    /// Covariance of the coordinates.
    pub covariance: DMatrix<f64>,
    /// Correlation matrix, row by row.
    pub correlation: Vec<Vec<f64>>,
}

impl Certainty {
    /// Returns the uncertainty of some coordinates, in this order.
    pub(super) fn of(&self, columns: &[usize]) -> Self {
        let count = columns.len();
        Certainty {
            sd: columns.iter().map(|c| self.sd[*c]).collect(),
            covariance: DMatrix::from_fn(count, count, |i, j| self.covariance[(columns[i], columns[j])]),
            correlation: columns
                .iter()
                .map(|i| columns.iter().map(|j| self.correlation[*i][*j]).collect())
                .collect(),
        }
    }
}

/// Factor (1) by which the data reduce the standard deviation of the reference width of an identifiable
/// parameter.
const NARROWING: f64 = 4.0;
/// Standard deviation of the uniform distribution on the unit interval, 1/√12.
pub(crate) const RANGE_SD: f64 = 0.288_675_134_594_812_9;
/// Reference width, as a ratio upper/lower (1): what is known of a stiffness before a measurement.
const REFERENCE: f64 = 3.0;

/// Returns the width of the widest 95 % interval with which a parameter is identifiable, as a share of its
/// range on its scale.
///
/// A parameter is identifiable if the data narrow its reference width fourfold. The reference width is a
/// factor of three, but no more than the plausible range. For a logarithmic range, the ends of the interval
/// thus differ by a factor of 1.36 at most: about ±15 % of the value. A stiffness known less well does not
/// suffice for predictions, however wide its range is.
///
/// On a linear scale the same share of the value counts: ln 3 times the value, narrowed fourfold, is ±15.5 %
/// of it. A quantity of either sign, such as an offset of the friction, may be zero, which no relative width
/// can express. Such a quantity acts by its sum with others: the largest value of its kind takes the place of
/// its own.
///
/// A prior must become narrower, too: the data have to reduce its standard deviation fourfold, or else the
/// catalogue would identify the parameter.
pub fn narrow_width(parameters: &[Parameter], values: &[f64], index: usize) -> f64 {
    let parameter = &parameters[index];
    let by_kind = match parameter.scale {
        Scale::Logarithmic => narrow_logarithmic_width((parameter.lower, parameter.upper)),
        Scale::Linear => narrowed(
            REFERENCE.ln() * magnitude(parameters, values, index) / (parameter.upper - parameter.lower),
        ),
    };
    let by_prior = |slope: f64| narrowed(1.0 / (slope.abs() * RANGE_SD));
    parameter.deviation_slope(values[index]).map_or(by_kind, |slope| by_kind.min(by_prior(slope)))
}

/// As [`narrow_width`] for any logarithmic range.
pub(super) fn narrow_logarithmic_width((lower, upper): (f64, f64)) -> f64 {
    narrowed(REFERENCE.ln() / (upper / lower).ln())
}

/// Returns the width of a 95 % interval that a reference width, a share of the range, leaves where it is
/// narrowed.
fn narrowed(reference: f64) -> f64 {
    2.0 * 1.96 * reference.min(1.0) * RANGE_SD / NARROWING
}

/// Returns the magnitude to which the width of an interval on a linear scale relates (unit of the parameter).
fn magnitude(parameters: &[Parameter], values: &[f64], index: usize) -> f64 {
    let own = &parameters[index];
    let has_either_sign = own.lower < 0.0 && own.upper > 0.0;
    let counts = |(at, other): &(usize, &Parameter)| *at == index || (has_either_sign && own.is_like(other));
    parameters.iter().enumerate().filter(counts).fold(0.0, |largest, (at, _)| values[at].abs().max(largest))
}

/// Computes the uncertainty from the information JᵀJ of weighted residuals, with the plausible ranges as
/// priors.
///
/// The prior standard deviation is 1/√12 of a range, so that a parameter without information keeps the width
/// of its range. `misfit` (1) multiplies the variance of the data: χ² per degree of freedom where that is
/// above 1.
pub fn certainty(information: &DMatrix<f64>, misfit: f64) -> Certainty {
    let count = information.nrows();
    let mut all = information / misfit;
    for d in 0..count {
        all[(d, d)] += 1.0 / (RANGE_SD * RANGE_SD);
    }
    let covariance =
        all.try_inverse().unwrap_or_else(|| DMatrix::identity(count, count) * (RANGE_SD * RANGE_SD));
    let sd: Vec<f64> = (0..count).map(|d| covariance[(d, d)].max(0.0).sqrt()).collect();
    let correlation =
        (0..count).map(|i| (0..count).map(|j| covariance[(i, j)] / (sd[i] * sd[j])).collect()).collect();
    Certainty { sd, covariance, correlation }
}

#[cfg(test)]
mod tests {
    use super::*;
    use machine::{FitRule, Mechanism, Role};

    #[test]
    fn parameter_without_information_keeps_its_range() {
        let result = certainty(&DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![1e4, 0.0])), 1.0);
        assert!((result.sd[0] - 0.01).abs() < 1e-5);
        assert!((result.sd[1] - RANGE_SD).abs() < 1e-9);
    }

    #[test]
    fn determined_sum_leaves_both_parts_open_and_correlated() {
        let result = certainty(&(DMatrix::from_element(2, 2, 1.0) * 1e6), 1.0);
        assert!(result.sd.iter().all(|sd| *sd > RANGE_SD / NARROWING));
        assert!(result.correlation[0][1] < -0.99);
    }

    /// Returns a parameter with a unit and a range, positive ones on a logarithmic scale.
    fn parameter(unit: &str, lower: f64, upper: f64) -> Parameter {
        Parameter {
            id: "p".into(),
            unit: unit.into(),
            mechanism: Mechanism::Force,
            role: Role::Described,
            start: upper,
            lower,
            upper,
            scale: if lower > 0.0 { Scale::Logarithmic } else { Scale::Linear },
            fit: FitRule::Always,
            prior: None,
            source: String::new(),
            description: String::new(),
        }
    }

    /// Returns the half width of the widest interval about a value with which the first parameter is
    /// identifiable (its unit).
    fn half_width(parameters: &[Parameter], values: &[f64]) -> f64 {
        let (own, half) = (&parameters[0], 0.5 * narrow_width(parameters, values, 0));
        0.5 * (own.from_unit(own.to_unit(values[0]) + half) - own.from_unit(own.to_unit(values[0]) - half))
    }

    /// However wide its range is, a parameter is identifiable within about ±15 % of its value, on a
    /// logarithmic as on a linear scale.
    #[test]
    fn limit_an_identifiable_value_is_known_to_fifteen_percent() {
        for (lower, upper) in [(1.0, 1e3), (1e-6, 1e9), (0.0, 1e3), (0.0, 1e6)] {
            for value in [20.0, 200.0] {
                let share = half_width(&[parameter("N", lower, upper)], &[value]) / value;
                assert!((share - 0.1555).abs() < 1e-3, "{lower} … {upper}, {value}: {share}");
            }
        }
    }

    /// The range of a parameter that is known well before the measurement has to become narrower, too.
    #[test]
    fn limit_a_narrow_range_alone_identifies_nothing() {
        for (lower, upper) in [(95.0, 105.0), (0.0, 10.0)] {
            let share = narrow_width(&[parameter("N", lower, upper)], &[100.0], 0);
            assert!((share - 1.96 * 2.0 / 4.0 / 12.0_f64.sqrt()).abs() < 1e-12, "{share}");
        }
    }

    /// An offset of zero is identifiable next to friction of its kind, not by the width of its range, and not
    /// by a quantity of another unit.
    #[test]
    fn limit_an_offset_counts_next_to_the_largest_value_of_its_kind() {
        let of = |unit: &str| [parameter("N", -100.0, 100.0), parameter(unit, 0.0, 500.0)];
        assert!((half_width(&of("N"), &[0.0, 20.0]) - 3.107).abs() < 1e-3);
        assert!((half_width(&of("N"), &[-40.0, 20.0]) - 6.215).abs() < 1e-3);
        assert_eq!(half_width(&of("N*m"), &[0.0, 20.0]), 0.0);
    }

    #[test]
    fn an_identifiable_parameter_depends_on_doubts() {
        let doubted = |identifiable| {
            let mut estimate = Estimate::without_interval(0, 1.0, Some(identifiable));
            estimate.doubt();
            (estimate.identifiable, estimate.depends)
        };
        assert_eq!((doubted(true), doubted(false)), ((None, true), (Some(false), false)));
    }
}
