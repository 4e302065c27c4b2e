//! 95 % intervals of the parameters of a friction curve.

use super::StribeckCurve;
use super::projection::inverse;

/// An interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterInterval {
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

impl ParameterInterval {
    /// Whether a value lies inside.
    pub fn contains(&self, value: f64) -> bool {
        value >= self.lower && value <= self.upper
    }
}

/// An estimated parameter with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterEstimate {
    /// Best value.
    pub value: f64,
    /// 95 % interval; `None` for a parameter at its bound or one that the data do not determine.
    pub interval_95: Option<ParameterInterval>,
    /// Whether the best value lies at a bound of its range: the optimum lies beyond it, or the parameter is
    /// not identifiable.
    pub at_bound: bool,
}

/// Whether each of (F_c, F_s, d, v_s) lies inside its bounds.
pub(super) type Free = [bool; 4];

/// Computes the standard errors of (F_c, F_s, d, ln v_s) for a noise scale of 1. `None` for a parameter that
/// is not free, and for all if the data do not determine them.
///
/// ```text
/// C = (Jᵀ W J)⁻¹    ∂f/∂F_c = 1 − e   ∂f/∂F_s = e   ∂f/∂d = |v|   ∂f/∂ln v_s = 2·(F_s − F_c)·(v/v_s)²·e   e = exp(−(v/v_s)²)
/// ```
///
/// (times sgn v each.) A parameter at its bound is held fixed: the intervals of the others are conditional on
/// it.
///
/// # Source  Seber and Wild, «Nonlinear Regression», section 5.1.
pub(super) fn standard_errors(
    curve: &StribeckCurve,
    rows: impl Iterator<Item = (f64, f64)>,
    free: Free,
) -> [Option<f64>; 4] {
    let mut normal = [[0.0; 4]; 4];
    for (speed, weight) in rows {
        let square = (speed / curve.stribeck_velocity_m_per_s).powi(2);
        let decay = (-square).exp();
        // Without a fall F_s equals F_c, and the curve has one constant only.
        let fall = if curve.static_n > curve.coulomb_n { decay } else { 0.0 };
        let slope = [1.0 - fall, fall, speed, 2.0 * (curve.static_n - curve.coulomb_n) * square * decay];
        for i in 0..4 {
            for j in 0..4 {
                normal[i][j] += weight * slope[i] * slope[j];
            }
        }
    }
    match inverse(&normal, free) {
        Some(covariance) => std::array::from_fn(|index| free[index].then(|| covariance[index][index].sqrt())),
        None => [None; 4],
    }
}

/// Returns value ± half, clipped at zero.
pub(super) fn symmetric(value: f64, half: f64) -> ParameterInterval {
    ParameterInterval { lower: (value - half).max(0.0), upper: value + half }
}

/// Returns value·exp(±half): an interval in the logarithm.
pub(super) fn in_logarithm(value: f64, half: f64) -> ParameterInterval {
    ParameterInterval { lower: value * (-half).exp(), upper: value * half.exp() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::published::friction_axis_1;

    /// Compares the slopes with finite differences of the curve, through the covariance of a single
    /// parameter.
    #[test]
    fn limit_slopes_are_finite_differences() {
        let curve = friction_axis_1();
        let speed = 0.5e-3;
        let change = |index: usize, step: f64| {
            let mut curve = curve;
            match index {
                0 => curve.coulomb_n += step,
                1 => curve.static_n += step,
                2 => curve.viscous_n_s_per_m += step,
                _ => curve.stribeck_velocity_m_per_s *= step.exp(),
            }
            curve.force_n(speed)
        };
        for (index, step) in [(0, 1e-3), (1, 1e-3), (2, 1e-1), (3, 1e-5)] {
            let slope = (change(index, step) - change(index, -step)) / (2.0 * step);
            let mut free = [false; 4];
            free[index] = true;
            let error = standard_errors(&curve, [(speed, 4.0)].into_iter(), free)[index].unwrap();
            assert!((error * 2.0 * slope.abs() - 1.0).abs() < 1e-6, "{index}");
        }
        // One speed does not determine two parameters.
        assert_eq!(
            standard_errors(&curve, [(speed, 1.0); 5].into_iter(), [true, true, false, false]),
            [None; 4]
        );
    }

    #[test]
    fn limit_intervals() {
        assert_eq!(symmetric(2.0, 3.0), ParameterInterval { lower: 0.0, upper: 5.0 });
        let interval = in_logarithm(2.0, 3.0_f64.ln());
        assert!((interval.lower - 2.0 / 3.0).abs() < 1e-15 && (interval.upper - 6.0).abs() < 1e-14);
        assert!(interval.contains(6.0 - 1e-9) && !interval.contains(6.1));
    }
}
