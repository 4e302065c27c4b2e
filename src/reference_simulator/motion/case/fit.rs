//! Least-squares fit of the engineer's parameters, and the remaining gap.

use nalgebra::{Matrix4, Vector4};

use super::rows::{Blocks, Row, rms, scales};
use crate::motion::belief::{Belief, IDS};

/// Fitted parameters and gaps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted {
    /// Parameters in the order of their ids; 0 for omitted ones.
    pub parameters: [f64; 4],
    /// Gap of the fitted records.
    pub fit: f64,
    /// Gap of the held-out records.
    pub held_out: f64,
}

/// Fits the records that are not held out by least squares. The noise of each kind of rows is its weight;
/// `frozen` fixes a parameter.
pub fn fitted(
    blocks: &Blocks,
    noise_n: &[f64],
    held_out: &[bool],
    belief: &Belief,
    frozen: Option<(&str, f64)>,
) -> Fitted {
    let free: [bool; 4] =
        std::array::from_fn(|k| belief.has(IDS[k]) && frozen.is_none_or(|(id, _)| id != IDS[k]));
    let kept = IDS.map(|id| frozen.filter(|(frozen, _)| *frozen == id).map_or(0.0, |(_, value)| value));
    let (mut normal, mut right) = (Matrix4::<f64>::zeros(), Vector4::<f64>::zeros());
    for (record, _) in blocks.iter().zip(held_out).filter(|(_, out)| !**out) {
        for (rows, noise) in record.iter().zip(noise_n) {
            for (row, value) in rows.iter().filter_map(|row| Some((row, row.residual(&kept)?))) {
                let columns = Vector4::from_fn(|k, _| if free[k] { row.columns[k] / noise } else { 0.0 });
                normal += columns * columns.transpose();
                right += columns * (value / noise);
            }
        }
    }
    if belief.is_weighed && free[0] {
        // The weighed mass has a standard deviation of one per cent.
        let start = belief.parameters[0].start;
        let weight = (0.01 * start).powi(-2);
        normal[(0, 0)] += weight;
        right[0] += weight * start;
    }
    for k in 0..4 {
        if !free[k] {
            normal[(k, k)] = 1.0;
        }
    }
    let found = normal.cholesky().map_or(Vector4::zeros(), |factors| factors.solve(&right));
    let parameters: [f64; 4] = std::array::from_fn(|k| if free[k] { found[k] } else { kept[k] });
    if let Some(weight) = belief
        .parameters
        .first()
        .filter(|weight| belief.is_weighed && free[0] && frozen.is_none() && weight.name == IDS[0])
    {
        let inside = parameters[0].clamp(weight.lower, weight.upper);
        if inside != parameters[0] {
            return fitted(blocks, noise_n, held_out, belief, Some((IDS[0], inside)));
        }
    }
    let gap = |out: bool| gap(blocks, &parameters, held_out, out);
    Fitted { parameters, fit: gap(false), held_out: gap(true) }
}

/// Returns the rms residual over the rms scale of the last kind of rows: force, or tracking error if a scale
/// measures the table.
pub fn gap(blocks: &Blocks, parameters: &[f64; 4], held_out: &[bool], out: bool) -> f64 {
    let chosen: Vec<&Vec<Row>> = blocks
        .iter()
        .zip(held_out)
        .filter(|(_, is_out)| **is_out == out)
        .filter_map(|(record, _)| record.last())
        .collect();
    let residual: Vec<f64> =
        chosen.iter().copied().flatten().filter_map(|row| row.residual(parameters)).collect();
    let scale: Vec<f64> = chosen.iter().flat_map(|rows| scales(rows)).collect();
    rms(&residual) / rms(&scale)
}
