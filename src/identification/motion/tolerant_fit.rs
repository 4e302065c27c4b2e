//! Parameters of a force fit next to the small print of friction and force, and whether they depend on what
//! the machine lacks.

use super::discrepancy::systematic_share;
use super::force_fit::{ForceFit, channels, estimate};
use super::marginal::{ToleranceSize, marginal};
use super::small_print::{SmallPrint, tolerances};
use crate::Doubt;
use crate::uncertainty::Estimate;
use dynamics::inverse_dynamics::{MotionSignal, Rigid, prediction, recorded};
use machine::{Machine, Value};
use nalgebra::DVector;

/// A force fit corrected for tolerances.
#[derive(Debug, Clone, PartialEq)]
pub struct TolerantFit {
    /// The corrected fit. Its residual is that of the parameters alone.
    pub fit: ForceFit,
    /// Free parameters with their intervals.
    pub estimates: Vec<Estimate>,
    /// Estimated sizes of the tolerances.
    pub sizes: Vec<ToleranceSize>,
    /// Share of the squared residual, parameters and tolerances fitted, that smooth functions of speed and
    /// acceleration explain.
    pub systematic_share: f64,
    /// Reasons to doubt that the fit is that of the machine.
    pub doubts: Vec<Doubt>,
}

/// Share of the squared residual above which its systematic part exceeds the rest, its noise.
const DISCREPANCY_SHARE: f64 = 0.5;
/// Size of a tolerance over the stated one above which the machine differs from its description.
const IMPLAUSIBLE: f64 = 2.0;
/// The same for kinds whose prior has a known standard deviation.
const IMPLAUSIBLE_DEVIATION: f64 = 4.0;

/// Change of a delay, in standard deviations, that is applied in place of its linear part, and most rounds of this.
const LINEAR_DELAY: f64 = 1.0;
const DELAY_ROUNDS: usize = 4;

/// Share of the squared force above which a machine that leaves it unexplained is not that of the records.
const UNEXPLAINED_SHARE: f64 = 0.5;

impl ToleranceSize {
    /// Whether the tolerance is larger than small print can be.
    fn is_implausible(&self) -> bool {
        self.value.abs() > if self.kind.is_sized() { IMPLAUSIBLE } else { IMPLAUSIBLE_DEVIATION }
    }
}

impl TolerantFit {
    /// Notes what casts doubt on the fit, and that its values depend on it.
    fn doubt(&mut self, motions: &[&MotionSignal]) {
        let large = self.sizes.iter().filter(|size| size.is_implausible());
        self.doubts = large.map(|size| Doubt::SmallPrint(size.kind.name(), size.value.abs())).collect();
        if self.systematic_share > DISCREPANCY_SHARE {
            self.doubts.push(Doubt::Systematic(self.systematic_share));
        }
        let unexplained = self.fit.squares / recorded(motions).norm_squared();
        if unexplained > UNEXPLAINED_SHARE {
            self.doubts.push(Doubt::Unexplained(unexplained));
        }
        if !self.doubts.is_empty() {
            self.estimates.iter_mut().for_each(Estimate::doubt);
        }
    }
}

/// Corrects a fit for the tolerances of friction, force and delay.
///
/// Parameters keep their least-squares values and have no intervals where the records have too few samples
/// for the noise of the residual.
pub fn estimate_with_tolerances(
    rigid: &Rigid,
    machine: &Machine,
    fit: ForceFit,
    motions: &[&MotionSignal],
) -> TolerantFit {
    let free = fit.free.clone();
    let inside = fit.inside(machine, &free);
    let channels = channels(motions);
    // Corrections are linear in the delay, about one that is applied.
    let correction = |machine: &Machine, fit: &ForceFit, applied: f64| {
        let small_print = tolerances(rigid, machine, &fit.values, motions);
        let mut residual = fit.residual.clone();
        let delays = small_print.iter().filter(|tolerance| tolerance.kind == SmallPrint::Delay);
        for delay in delays {
            residual.axpy(applied, &DVector::from_column_slice(&delay.force), 1.0);
        }
        marginal(&fit.derivatives.select_columns(&inside), &residual, &small_print, &channels)
    };
    let Some(mut found) = correction(machine, &fit, 0.0) else {
        let estimates = fit.estimates_with(machine, &free, &inside, None);
        return TolerantFit { fit, estimates, sizes: Vec::new(), systematic_share: 0.0, doubts: Vec::new() };
    };
    let (mut fit, mut delayed) = (fit, machine.clone());
    let mut applied = 0.0;
    for _ in 0..DELAY_ROUNDS {
        let is_long = |delay: &ToleranceSize| (delay.value - applied).abs() > LINEAR_DELAY;
        let Some(delay) = found.delay().filter(is_long) else { break };
        delayed.chain.delay = Value::number(delay.value * delay.stated);
        let Ok(again) = estimate(rigid, &delayed, &fit.values, &free, motions) else { break };
        let Some(corrected) = correction(&delayed, &again, delay.value) else { break };
        fit = ForceFit { single_frequency: fit.single_frequency, ..again };
        (found, applied) = (corrected, delay.value);
    }
    let mut corrected = fit;
    for (at, change) in inside.iter().zip(found.change.iter()) {
        let parameter = &machine.parameters[free[*at]];
        let value = &mut corrected.values.0[free[*at]];
        *value = (*value + change).clamp(parameter.lower, parameter.upper);
    }
    corrected.residual = recorded(motions) - prediction(rigid, machine, &corrected.values, motions);
    corrected.squares = corrected.residual.norm_squared();
    corrected.evaluations += 1;
    let estimates = corrected.estimates_with(machine, &free, &inside, Some(&found.half_widths));
    let systematic_share = systematic_share(&found, motions, &channels);
    let (sizes, doubts) = (found.sizes, Vec::new());
    let mut fit = TolerantFit { fit: corrected, estimates, sizes, systematic_share, doubts };
    fit.doubt(motions);
    fit
}
