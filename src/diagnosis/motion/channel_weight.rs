//! Weights of channels: the noise of each is its unit.

use nalgebra::DVector;

use super::data::MotionData;
use super::free_function::free_functions;
use dynamics::inverse_dynamics::{InverseError, MotionSignal, Rigid, weights};
use identification::motion::estimate_identifiable;
use machine::Machine;
use numeric::linear_fit::LinearFit;

/// Number of alternations of fit and weights.
const ROUNDS: usize = 2;

/// Weights the extra channels of motions by the noise of a fit to the first `fitted` motions. The residual
/// beyond smooth functions counts as noise: a missing effect must not.
///
/// # Errors  as [`estimate_identifiable`].
pub(super) fn weigh(
    rigid: &Rigid,
    machine: &Machine,
    free: &[usize],
    may_drop: impl Fn(usize) -> bool,
    motions: &mut [MotionSignal],
    fitted: usize,
) -> Result<(), InverseError> {
    if motions.iter().all(|m| m.extra_channels.is_empty()) {
        return Ok(());
    }
    for _ in 0..ROUNDS {
        let data = MotionData::new(motions[..fitted].iter().collect());
        let fit =
            estimate_identifiable((rigid, machine), &machine.start(), free, &data.motions, None, &may_drop)?;
        let left = without_smooth_functions(&data, fit.residual);
        let weights = weights(left.as_slice(), &data.motions);
        motions.iter_mut().for_each(|m| m.set_weights(&weights));
    }
    Ok(())
}

/// Removes smooth functions of speed, position, acceleration and travel since reversal from a residual.
pub(super) fn without_smooth_functions(data: &MotionData<'_>, residual: DVector<f64>) -> DVector<f64> {
    free_functions(data).iter().fold(residual, |left, shape| {
        // The hat functions of all knots sum to a constant or a direction: leave one out.
        let kept: Vec<usize> = (0..shape.columns.ncols().saturating_sub(1)).collect();
        LinearFit::new(&shape.columns.select_columns(&kept), &left).map_or(left, |fit| fit.residual)
    })
}
