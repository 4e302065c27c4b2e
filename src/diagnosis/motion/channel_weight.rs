//! How much each channel counts: its own noise is the unit.

use nalgebra::DVector;

use super::data::MotionData;
use super::free_function::free_functions;
use dynamics::inverse_dynamics::{InverseError, MotionSignal, Rigid, weights};
use identification::motion::estimate_identifiable;
use machine::Machine;
use numeric::linear_fit::LinearFit;

/// Rounds of fit and weights.
const ROUNDS: usize = 2;

/// Weighs the further points of motions, of which the first `fitted` are fitted, by what smooth functions leave of a fit: what is missing of the
/// machine is no noise.
///
/// # Errors  as [`estimate_told`].
pub(super) fn weigh(
    rigid: &Rigid,
    machine: &Machine,
    free: &[usize],
    may: impl Fn(usize) -> bool,
    motions: &mut [MotionSignal],
    fitted: usize,
) -> Result<(), InverseError> {
    if motions.iter().all(|m| m.further.is_empty()) {
        return Ok(());
    }
    for _ in 0..ROUNDS {
        let data = MotionData::new(motions[..fitted].iter().collect());
        let fit = estimate_identifiable(rigid, machine, &machine.start(), free, &data.motions, &may)?;
        let left = smooth_taken(&data, fit.residual);
        let weights = weights(left.as_slice(), &data.motions);
        motions.iter_mut().for_each(|m| m.weigh(&weights));
    }
    Ok(())
}

/// What smooth functions of speed, position, acceleration and travel since reversal leave of a residual.
pub(super) fn smooth_taken(data: &MotionData<'_>, residual: DVector<f64>) -> DVector<f64> {
    free_functions(data).iter().fold(residual, |left, shape| {
        // Knots add up to a constant or a direction: one is left out.
        let kept: Vec<usize> = (0..shape.columns.ncols().saturating_sub(1)).collect();
        LinearFit::new(&shape.columns.select_columns(&kept), &left).map_or(left, |fit| fit.residual)
    })
}
