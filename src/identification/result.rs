//! Result of an identification.

use super::bootstrap::Bootstrap;
use super::combination::Combination;
use super::doubt::Doubt;
use super::place::Place;
use super::posterior::Posterior;
use super::problem::Basin;
use super::search::SearchEffort;
use super::settings::Repeat;
use super::tolerance::ToleranceEstimate;
use super::uncertainty::{Certainty, Estimate};
use crate::objective::{AmplitudeFit, Channel, FrfGap, PositionPrediction};
use dynamics::model::derived;
use machine::{Machine, Operating, ParameterValues};

/// A quantity derived from the parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct DerivedEstimate {
    /// Name, with its unit.
    pub name: String,
    /// Value.
    pub value: f64,
    /// 95 % interval, to first order; `None` where χ² is no likelihood.
    pub interval95: Option<(f64, f64)>,
}

/// Result of an identification.
#[derive(Debug, Clone, PartialEq)]
pub struct Identification {
    /// The machine as fitted: if tolerances were fitted, they follow its own parameters.
    pub machine: Machine,
    /// Estimates of all parameters of the machine as described, in its order.
    pub estimates: Vec<Estimate>,
    /// Reasons to doubt that the fit is that of the machine.
    pub doubts: Vec<Doubt>,
    /// Values of all parameters of the machine as fitted.
    pub values: ParameterValues,
    /// Fitted nuisance parameters; empty where they are held fixed.
    pub tolerances: Vec<ToleranceEstimate>,
    /// Gain and delay of each measurement channel.
    pub channels: Vec<Channel>,
    /// Minima of χ² that the data cannot distinguish from the least one, the best first.
    pub basins: Vec<Basin>,
    /// Gain of the measured amplitudes.
    pub gain: AmplitudeFit,
    /// Least cost.
    pub cost: f64,
    /// Number of evaluations of all rounds.
    pub evaluations: u64,
    /// The rounds of the search, best first.
    pub repeats: Vec<Repeat>,
    /// How far the search went.
    pub effort: SearchEffort,
    /// Whether the best minimum was found as often as required; `None` where it had to be found once, or the
    /// search was stopped.
    pub agree: Option<bool>,
    /// Sum of the squared weighted residuals.
    pub chi_square: f64,
    /// Degrees of freedom: observations less unknowns.
    pub degrees_of_freedom: usize,
    /// 95 % interval of the gain, where it was estimated.
    pub gain_interval95: Option<(f64, f64)>,
    /// Whether the gain is identifiable, where it was estimated; `None` also where it depends on a doubt.
    pub gain_identifiable: Option<bool>,
    /// Uncertainty and identifiability of the free parameters, and last of the gain where it was estimated.
    pub certainty: Certainty,
    /// Derived quantities of the machine, at mid-stroke.
    pub derived: Vec<DerivedEstimate>,
    /// Combinations of parameters that the data determine better than the parameters themselves.
    pub combinations: Vec<Combination>,
    /// Results of the requested bootstraps.
    pub bootstraps: Vec<Bootstrap>,
    /// Variance inflation by correlation of neighbouring lines (1).
    pub correlation_factor: f64,
    /// Unit-cube coordinates of the best fit: free parameters, and last the gain where it was estimated.
    pub place: Place,
    /// Standard deviation of every unit-cube coordinate, nuisance parameters included.
    pub(super) sd: Vec<f64>,
    /// Minima and covariance of all fitted coordinates; `None` where χ² is no likelihood.
    pub posterior: Option<Posterior>,
    /// Indices of the free parameters of the machine as described.
    pub free: Vec<usize>,
    /// Indices of all varied parameters, tolerances included: the first unit-cube coordinates.
    pub varied_parameters: Vec<usize>,
    /// Predicted modes of the fitted positions; empty for FRFs.
    pub fitted: Vec<PositionPrediction>,
    /// Predicted modes of the held-out positions; empty for FRFs.
    pub held_out: Vec<PositionPrediction>,
    /// Gaps of the fitted FRFs; empty for modes.
    pub fitted_frfs: Vec<FrfGap>,
    /// Gaps of the held-out FRFs; empty for modes.
    pub held_out_frfs: Vec<FrfGap>,
    /// Number of real numbers that were fitted.
    pub observations: usize,
    /// Whether the identification ran to its end.
    pub complete: bool,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

impl Identification {
    /// Returns the result with further doubts: no value is identifiable then.
    pub(super) fn doubted(mut self, doubts: Vec<Doubt>) -> Self {
        self.doubts.extend(doubts);
        if !self.doubts.is_empty() {
            self.estimates.iter_mut().for_each(Estimate::doubt);
            self.gain_identifiable = self.gain_identifiable.filter(|is| !is);
        }
        self
    }

    /// Returns χ² per degree of freedom; 1 without degrees of freedom.
    pub(super) fn misfit(&self) -> f64 {
        if self.degrees_of_freedom > 0 { self.chi_square / self.degrees_of_freedom as f64 } else { 1.0 }
    }
}

/// Step of the central differences for intervals of derived quantities, in the unit interval (1).
const STEP: f64 = 1e-5;

/// Computes the derived quantities of the machine as fitted, with intervals to first order.
pub(super) fn derived_estimates(found: &Identification) -> Vec<DerivedEstimate> {
    let (machine, free) = (&found.machine, &found.free);
    if machine.derived.is_empty() {
        return Vec::new();
    }
    let operating = Operating::at(machine.stroke_m().map(|s| 0.5 * s));
    let here = derived(machine, &found.values, &operating);
    // d(quantity)/d(coordinate), column by column.
    let moved = |column: usize, by: f64| {
        let parameter = &machine.parameters[free[column]];
        let mut values = found.values.clone();
        values[free[column]] = parameter.from_unit(found.place[column] + by);
        derived(machine, &values, &operating)
    };
    let (low, high): (Vec<_>, Vec<_>) = (0..free.len()).map(|c| (moved(c, -STEP), moved(c, STEP))).unzip();
    let has_intervals = found.estimates.iter().any(|e| e.interval95.is_some());
    machine
        .derived
        .iter()
        .enumerate()
        .filter_map(|(at, quantity)| {
            let value = here[at]?;
            let slopes: Option<Vec<f64>> = low
                .iter()
                .zip(&high)
                .map(|(low, high)| Some((high[at]? - low[at]?) / (2.0 * STEP)))
                .collect();
            let interval95 = slopes.filter(|_| has_intervals).map(|slopes| {
                let covariance = &found.certainty.covariance;
                let variance: f64 = (0..slopes.len())
                    .map(|i| {
                        (0..slopes.len()).map(|j| slopes[i] * covariance[(i, j)] * slopes[j]).sum::<f64>()
                    })
                    .sum();
                let half = 1.96 * variance.max(0.0).sqrt();
                (value - half, value + half)
            });
            Some(DerivedEstimate { name: quantity.name.clone(), value, interval95 })
        })
        .collect()
}
