//! Least squares of a candidate, with everything that does not depend on the recorded force worked out beforehand: nulls are many.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::data::MotionData;

/// Linear columns with what is known of their coefficients.
#[derive(Debug, Clone)]
pub(super) struct Design {
    /// Force with all coefficients at nothing.
    pub shift: DVector<f64>,
    /// Columns.
    pub columns: DMatrix<f64>,
    /// The same, row by row.
    rows: Vec<f64>,
    /// Ends of the coefficients that the candidate adds, by column.
    pub bounds: Vec<(usize, f64, f64)>,
    penalty: Vec<f64>,
    gram: Vec<DMatrix<f64>>,
    solve_without: Vec<DMatrix<f64>>,
    solve: DMatrix<f64>,
}

/// A recorded (or drawn) force and what a design makes of it.
#[derive(Debug, Clone)]
pub(super) struct Solved {
    /// Coefficients from all parts.
    pub coefficients: DVector<f64>,
    /// Sum of squares of each part foretold without it.
    pub left_out: Vec<f64>,
    /// What is known of the coefficients speaks against them by so much, in the same unit.
    pub prior: f64,
}

impl Solved {
    /// What is not foretold, and what is not believed.
    pub fn loss(&self) -> f64 {
        self.left_out.iter().sum::<f64>() + self.prior
    }
}

impl Design {
    /// `penalty` is added to the diagonal of the normal equations, column by column: 0, or the noise's variance over that of the coefficient.
    /// `None` where columns are not independent.
    pub fn new(
        data: &MotionData<'_>,
        shift: DVector<f64>,
        columns: DMatrix<f64>,
        penalty: &[f64],
        bounds: Vec<(usize, f64, f64)>,
    ) -> Option<Self> {
        let count = columns.ncols();
        // Scaled to length one, so that the inverse is exact where units differ.
        let lengths: Vec<f64> = columns.column_iter().map(|c| c.norm()).collect();
        if lengths.iter().any(|l| !(*l > 0.0 && l.is_finite())) {
            return None;
        }
        let mut gram = vec![DMatrix::zeros(count, count); data.parts];
        for (row, &part) in data.part.iter().enumerate() {
            let gram = &mut gram[part];
            for i in 0..count {
                let a = columns[(row, i)];
                for j in 0..=i {
                    gram[(i, j)] += a * columns[(row, j)];
                }
            }
        }
        gram.iter_mut().for_each(|g| g.fill_upper_triangle_with_lower_triangle());
        let all: DMatrix<f64> = gram.iter().fold(DMatrix::zeros(count, count), |s, g| s + g);
        let inverse = |mut normal: DMatrix<f64>| {
            for i in 0..count {
                normal[(i, i)] += penalty[i];
            }
            let scaled = DMatrix::from_fn(count, count, |i, j| normal[(i, j)] / (lengths[i] * lengths[j]));
            let inverse = Cholesky::new(scaled).filter(|c| (0..count).all(|i| c.l()[(i, i)] > 1e-5))?.inverse();
            Some(DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] / (lengths[i] * lengths[j])))
        };
        let solve = inverse(all.clone())?;
        let solve_without: Option<Vec<DMatrix<f64>>> = gram.iter().map(|g| inverse(&all - g)).collect();
        let rows = columns.transpose().as_slice().to_vec();
        let penalty = penalty.to_vec();
        Some(Design { shift, columns, rows, bounds, penalty, gram, solve_without: solve_without?, solve })
    }

    /// Fits a force, and foretells each part from a fit without it. `None` where what the candidate adds would leave its range.
    pub fn solve(&self, data: &MotionData<'_>, y: &DVector<f64>) -> Option<Solved> {
        let count = self.columns.ncols();
        let mut sums = vec![0.0; count * data.parts];
        let mut squares = vec![0.0; data.parts];
        for ((row, &part), (y, shift)) in self.rows.chunks_exact(count).zip(&data.part).zip(y.iter().zip(self.shift.iter())) {
            let z = y - shift;
            squares[part] += z * z;
            let sum = &mut sums[part * count..(part + 1) * count];
            sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += z * x);
        }
        let products: Vec<DVector<f64>> = sums.chunks_exact(count).map(DVector::from_column_slice).collect();
        let all: DVector<f64> = products.iter().fold(DVector::zeros(count), |s, p| s + p);
        let coefficients = &self.solve * &all;
        if self.bounds.iter().any(|&(at, lower, upper)| !(coefficients[at] >= lower && coefficients[at] <= upper)) {
            return None;
        }
        let left_out = (0..data.parts)
            .map(|part| {
                let kept = &self.solve_without[part] * (&all - &products[part]);
                squares[part] - 2.0 * kept.dot(&products[part]) + kept.dot(&(&self.gram[part] * &kept))
            })
            .collect();
        let prior = coefficients.iter().zip(&self.penalty).map(|(c, p)| p * c * c).sum();
        Some(Solved { coefficients, left_out, prior })
    }

    /// What is left of a force.
    pub fn residual(&self, y: &DVector<f64>, solved: &Solved) -> DVector<f64> {
        y - &self.shift - &self.columns * &solved.coefficients
    }

    /// Share of a further column that these columns cannot stand for.
    pub fn visible(&self, column: &DVector<f64>) -> f64 {
        let stood_for = &self.columns * (&self.solve * (self.columns.transpose() * column));
        (column - stood_for).norm() / column.norm()
    }
}
