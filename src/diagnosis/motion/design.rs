//! Least squares of a candidate, with everything that does not depend on the recorded force worked out beforehand: nulls are many, and are solved
//! together.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::data::{MotionData, beside};

/// Forces to be fitted: one recorded, or many drawn.
pub(super) struct Forces {
    /// One force a column, its samples in the order of the parts that are left out.
    sorted: DMatrix<f64>,
    /// Sum of squares of each part (row) of each force.
    squares: DMatrix<f64>,
    /// The columns that designs have in common, and products of each part with them.
    common: Rows,
    products: Vec<DMatrix<f64>>,
}

impl Forces {
    /// Of forces in the order of the records, for designs that share the columns of one.
    pub fn new(data: &MotionData<'_>, forces: &[DVector<f64>], design: &Design) -> Self {
        let sorted = DMatrix::from_fn(data.samples(), forces.len(), |row, at| forces[at][data.order[row]]);
        let squares = DMatrix::from_fn(data.parts(), forces.len(), |part, at| {
            let (from, count) = data.rows_of(part);
            sorted.view((from, at), (count, 1)).norm_squared()
        });
        let products = (0..data.parts()).map(|part| product(data, part, &design.common, &sorted)).collect();
        Forces { sorted, squares, common: design.common.clone(), products }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.sorted.ncols()
    }
}

fn product(data: &MotionData<'_>, part: usize, columns: &DMatrix<f64>, forces: &DMatrix<f64>) -> DMatrix<f64> {
    let (from, samples) = data.rows_of(part);
    columns.columns(from, samples) * forces.rows(from, samples)
}

/// Columns, each a row, their samples in the order of the parts.
pub(super) type Rows = Arc<DMatrix<f64>>;

/// Linear columns with what is known of their coefficients.
#[derive(Debug, Clone)]
pub(super) struct Design {
    /// Force with all coefficients at nothing, its samples in the order of the parts.
    shift: DVector<f64>,
    /// Sum of squares of each of its parts, and its products with all columns.
    shift_squares: Vec<f64>,
    shift_products: Vec<DVector<f64>>,
    /// The first columns, which many designs have in common.
    pub common: Rows,
    /// The others.
    own: DMatrix<f64>,
    /// Ends of the coefficients that the candidate adds, by column.
    pub bounds: Vec<(usize, f64, f64)>,
    penalty: Vec<f64>,
    gram: Vec<DMatrix<f64>>,
    solve_without: Vec<DMatrix<f64>>,
    solve: DMatrix<f64>,
}

/// Columns in the order of the records, each made a row in the order of the parts.
pub(super) fn rows(data: &MotionData<'_>, columns: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(columns.ncols(), columns.nrows(), |i, row| columns[(data.order[row], i)])
}

/// What a design makes of a force.
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
        shift: &DVector<f64>,
        (common, own): (Rows, DMatrix<f64>),
        penalty: &[f64],
        bounds: Vec<(usize, f64, f64)>,
    ) -> Option<Self> {
        let count = common.nrows() + own.nrows();
        let lengths: Vec<f64> = common.row_iter().chain(own.row_iter()).map(|row| row.norm()).collect();
        if lengths.iter().any(|l| !(*l > 0.0 && l.is_finite())) {
            return None;
        }
        let shift = DVector::from_fn(shift.len(), |row, _| shift[data.order[row]]);
        let (mut gram, mut shift_squares, mut shift_products) = (Vec::new(), Vec::new(), Vec::new());
        for part in 0..data.parts() {
            let (from, samples) = data.rows_of(part);
            let (a, b, s) = (common.columns(from, samples), own.columns(from, samples), shift.rows(from, samples));
            let (at, bt) = (a.transpose(), b.transpose());
            let cross = b * &at;
            gram.push(beside(&[&stacked(&(a * &at), &cross), &stacked(&cross.transpose(), &(b * &bt))]));
            shift_squares.push(s.norm_squared());
            let (a, b) = (a * s, b * s);
            shift_products.push(DVector::from_iterator(count, a.iter().chain(b.iter()).copied()));
        }
        let all: DMatrix<f64> = gram.iter().fold(DMatrix::zeros(count, count), |s, g| s + g);
        let inverse = |normal: DMatrix<f64>| inverse(normal, penalty, &lengths);
        let solve = inverse(all.clone())?;
        let solve_without: Option<Vec<DMatrix<f64>>> = gram.iter().map(|g| inverse(&all - g)).collect();
        let (solve_without, penalty) = (solve_without?, penalty.to_vec());
        Some(Design { shift, shift_squares, shift_products, common, own, bounds, penalty, gram, solve_without, solve })
    }

    /// Fits forces, and foretells each part from a fit without it. `None` where what the candidate adds would leave its range.
    pub fn solve(&self, data: &MotionData<'_>, forces: &Forces) -> Vec<Option<Solved>> {
        let given = forces.count();
        let mut all = DMatrix::zeros(self.solve.nrows(), given);
        let products: Vec<DMatrix<f64>> = (0..data.parts())
            .map(|part| {
                let own = product(data, part, &self.own, &forces.sorted);
                let mut product = if Arc::ptr_eq(&self.common, &forces.common) {
                    stacked(&forces.products[part], &own)
                } else {
                    stacked(&product(data, part, &self.common, &forces.sorted), &own)
                };
                product.column_iter_mut().for_each(|mut column| column -= &self.shift_products[part]);
                all += &product;
                product
            })
            .collect();
        let coefficients = &self.solve * &all;
        let inside = |at: &usize| self.bounds.iter().all(|&(i, lower, upper)| (lower..=upper).contains(&coefficients[(i, *at)]));
        let inside: Vec<usize> = (0..given).filter(inside).collect();
        let mut solved = vec![None; given];
        if inside.is_empty() {
            return solved;
        }
        let sums = all.select_columns(&inside);
        let mut left_out = DMatrix::zeros(data.parts(), inside.len());
        for (part, product) in products.iter().enumerate() {
            let (from, samples) = data.rows_of(part);
            let product = product.select_columns(&inside);
            let kept = &self.solve_without[part] * (&sums - &product);
            let bent = &self.gram[part] * &kept;
            let shift = self.shift.rows(from, samples);
            for (k, &at) in inside.iter().enumerate() {
                let force = forces.sorted.view((from, at), (samples, 1));
                let own = forces.squares[(part, at)] - 2.0 * force.dot(&shift) + self.shift_squares[part];
                left_out[(part, k)] = own + kept.column(k).dot(&(bent.column(k) - 2.0 * product.column(k)));
            }
        }
        for (k, at) in inside.into_iter().enumerate() {
            let coefficients = coefficients.column(at).clone_owned();
            let prior = coefficients.iter().zip(&self.penalty).map(|(c, p)| p * c * c).sum();
            solved[at] = Some(Solved { coefficients, left_out: left_out.column(k).iter().copied().collect(), prior });
        }
        solved
    }

    /// The force with these coefficients, in the order of the records.
    pub fn force(&self, data: &MotionData<'_>, coefficients: &DVector<f64>) -> DVector<f64> {
        let (first, own) = (self.common.nrows(), self.own.nrows());
        let sorted = &self.shift + self.common.tr_mul(&coefficients.rows(0, first)) + self.own.tr_mul(&coefficients.rows(first, own));
        let mut force = DVector::zeros(sorted.len());
        data.order.iter().zip(sorted.iter()).for_each(|(row, x)| force[*row] = *x);
        force
    }

    /// Covariance of coefficients over the variance of the noise, where all is known of them that `penalty` says.
    pub fn covariance(&self, from: usize, count: usize) -> DMatrix<f64> {
        self.solve.view((from, from), (count, count)).clone_owned()
    }
}

/// Inverse of normal equations with a penalty, through columns of length one, so that it is exact where units differ; `None` where columns are not
/// independent.
fn inverse(mut normal: DMatrix<f64>, penalty: &[f64], lengths: &[f64]) -> Option<DMatrix<f64>> {
    let count = normal.nrows();
    for i in 0..count {
        normal[(i, i)] += penalty[i];
    }
    let scaled = DMatrix::from_fn(count, count, |i, j| normal[(i, j)] / (lengths[i] * lengths[j]));
    let inverse = Cholesky::new(scaled).filter(|c| (0..count).all(|i| c.l_dirty()[(i, i)] > 1e-5))?.inverse();
    Some(DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] / (lengths[i] * lengths[j])))
}

/// Penalised least squares; `None` where columns are not independent.
pub(super) fn penalised(columns: &DMatrix<f64>, penalty: &[f64], y: &DVector<f64>) -> Option<DVector<f64>> {
    let lengths: Vec<f64> = columns.column_iter().map(|c| c.norm()).collect();
    Some(inverse(columns.tr_mul(columns), penalty, &lengths)? * columns.tr_mul(y))
}

fn stacked(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(a.nrows() + b.nrows(), a.ncols());
    all.rows_mut(0, a.nrows()).copy_from(a);
    all.rows_mut(a.nrows(), b.nrows()).copy_from(b);
    all
}
