//! The engineer's parameters fitted by least squares, and the gap that is left.

use nalgebra::{Matrix4, Vector4};

use super::rows::{Rows, rms};
use crate::motion::belief::{Belief, IDS};

/// Rows of every record, by record and kind.
pub type Blocks = Vec<Vec<Rows>>;

/// Parameters and gaps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted {
    /// Parameters in the order of their ids; 0 for those left out.
    pub parameters: [f64; 4],
    /// Gap of the fitted records.
    pub fit: f64,
    /// Gap of the held-out ones.
    pub held_out: f64,
}

/// Least squares over the fitted records, each kind of rows weighed by its noise; `frozen` keeps a parameter.
pub fn fitted(blocks: &Blocks, noise_n: &[f64], held_out: &[bool], belief: &Belief, frozen: Option<(usize, f64)>) -> Fitted {
    let free: [bool; 4] = std::array::from_fn(|k| belief.has(IDS[k]) && frozen.is_none_or(|(at, _)| at != k));
    let mut kept = [0.0; 4];
    if let Some((at, value)) = frozen {
        kept[at] = value;
    }
    let (mut normal, mut right) = (Matrix4::<f64>::zeros(), Vector4::<f64>::zeros());
    for (record, _) in blocks.iter().zip(held_out).filter(|(_, out)| !**out) {
        for (rows, noise) in record.iter().zip(noise_n) {
            for (columns, value) in rows.columns.iter().zip(rows.residual(&kept)).filter_map(|(columns, value)| Some((columns, value?))) {
                let columns = Vector4::from_fn(|k, _| if free[k] { columns[k] / noise } else { 0.0 });
                normal += columns * columns.transpose();
                right += columns * (value / noise);
            }
        }
    }
    if belief.is_weighed && free[0] {
        // The weight is known to one per cent.
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
    if let Some(weight) = belief.parameters.first().filter(|weight| belief.is_weighed && free[0] && frozen.is_none() && weight.id == IDS[0])
    {
        let inside = parameters[0].clamp(weight.lower, weight.upper);
        if inside != parameters[0] {
            return fitted(blocks, noise_n, held_out, belief, Some((0, inside)));
        }
    }
    let gap = |out: bool| gap(blocks, &parameters, held_out, out);
    Fitted { parameters, fit: gap(false), held_out: gap(true) }
}

/// Root mean square of what is left over that of the last kind of rows: force, or tracking error where a scale watches the table.
pub fn gap(blocks: &Blocks, parameters: &[f64; 4], held_out: &[bool], out: bool) -> f64 {
    let chosen: Vec<&Rows> =
        blocks.iter().zip(held_out).filter(|(_, is_out)| **is_out == out).filter_map(|(record, _)| record.last()).collect();
    let left: Vec<f64> = chosen.iter().flat_map(|rows| rows.residual(parameters)).flatten().collect();
    let scale: Vec<f64> = chosen.iter().flat_map(|rows| rows.scales()).collect();
    rms(&left) / rms(&scale)
}
