//! Projection of a change onto the complement of given directions.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::{Result, SimulatorError};

/// Directions, each scaled to one standard deviation of its prior.
pub struct Projection {
    columns: DMatrix<f64>,
    normal: Cholesky<f64, Dyn>,
}

impl Projection {
    /// Builds the projection from columns of equal height.
    pub fn new(columns: &[Vec<f64>]) -> Result<Self> {
        let rows = columns.first().map_or(0, Vec::len);
        let columns = DMatrix::from_iterator(rows, columns.len(), columns.iter().flatten().copied());
        let normal = columns.transpose() * &columns + DMatrix::identity(columns.ncols(), columns.ncols());
        let normal = Cholesky::new(normal).ok_or(SimulatorError::Singular { frequency_hz: f64::NAN })?;
        Ok(Self { columns, normal })
    }

    /// Returns the residual of a change after the directions, within their priors, explain their part.
    pub fn residual(&self, change: &DVector<f64>) -> DVector<f64> {
        change - &self.columns * self.normal.solve(&(self.columns.transpose() * change))
    }
}
