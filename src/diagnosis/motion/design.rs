//! Least squares of candidates whose designs share columns. Everything that does not depend on the force is
//! computed once, and null simulations are solved in batches. A candidate stores its own columns alone: they
//! border the normal equations of the shared ones.
//!
//! ```text
//! ┌ A   B ┐ ┌c┐   ┌a┐      U = A⁻¹·B     S = C − Bᵀ·U      z = S⁻¹·(b − Uᵀ·a)      c = A⁻¹·a − U·z
//! └ Bᵀ  C ┘ └z┘ = └b┘
//! ```
//!
//! # Source  the inverse of a bordered matrix: Golub and Van Loan, Matrix Computations, 4th ed. (2013),
//!   3.2.11.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::data::{MotionData, side_by_side};

/// Columns shared by designs, with penalties on their coefficients.
#[derive(Debug)]
pub(super) struct SharedDesign {
    /// The columns as rows, with samples in the order of the parts.
    rows: DMatrix<f64>,
    penalty: Vec<f64>,
    /// Gram matrices of the columns in each part.
    gram: Vec<DMatrix<f64>>,
    /// Inverses of the normal equations without each part; the last with all parts.
    inverses: Vec<DMatrix<f64>>,
}

impl SharedDesign {
    /// Builds the design from columns in the order of the records. `penalty` is added to the diagonal of the
    /// normal equations: 0, or the variance of the noise over that of the coefficient. `None` where columns
    /// are linearly dependent.
    pub fn new(data: &MotionData<'_>, columns: &DMatrix<f64>, penalty: Vec<f64>) -> Option<Self> {
        let rows = sorted(data, columns).transpose();
        let lengths = lengths(columns)?;
        let gram: Vec<DMatrix<f64>> = (0..data.parts())
            .map(|part| {
                let (from, samples) = data.rows_of(part);
                let own = rows.columns(from, samples);
                own * own.transpose()
            })
            .collect();
        let all: DMatrix<f64> = gram.iter().sum();
        let inverse = |normal: DMatrix<f64>| inverse(normal, &penalty, &lengths);
        let inverses: Option<Vec<DMatrix<f64>>> =
            gram.iter().map(|part| &all - part).chain([all.clone()]).map(inverse).collect();
        Some(SharedDesign { inverses: inverses?, rows, penalty, gram })
    }
}

/// Forces to fit, recorded or drawn, one per column, with their products with shared columns.
pub(super) struct Forces {
    /// Forces, with samples in the order of the parts.
    sorted: DMatrix<f64>,
    /// Sum of squares of each part (row).
    squares: DMatrix<f64>,
    shared: Vec<SharedProducts>,
}

/// Products of forces with shared columns in each part and in total, and coefficients of each fit by shared
/// columns alone. Also the products of these coefficients with the Gram matrix of the left-out part.
struct SharedProducts {
    base: Arc<SharedDesign>,
    products: Vec<DMatrix<f64>>,
    sums: DMatrix<f64>,
    coefficients: Vec<DMatrix<f64>>,
    gram_products: Vec<DMatrix<f64>>,
}

impl Forces {
    /// Prepares forces in the order of the records for designs on given shared columns.
    pub fn new(data: &MotionData<'_>, forces: &[DVector<f64>], bases: &[Arc<SharedDesign>]) -> Self {
        let sorted = sorted(data, &DMatrix::from_columns(forces));
        let squares = DMatrix::from_fn(data.parts(), forces.len(), |part, at| {
            let (from, count) = data.rows_of(part);
            sorted.view((from, at), (count, 1)).norm_squared()
        });
        let of = |base: &Arc<SharedDesign>| {
            let products = with_shared(data, base, &sorted);
            let sums: DMatrix<f64> = products.iter().sum();
            let rests = products.iter().map(|part| &sums - part).chain([sums.clone()]);
            let coefficients: Vec<DMatrix<f64>> =
                base.inverses.iter().zip(rests).map(|(inverse, rest)| inverse * rest).collect();
            let gram_products = base.gram.iter().zip(&coefficients).map(|(gram, c)| gram * c).collect();
            SharedProducts { base: base.clone(), products, sums, coefficients, gram_products }
        };
        Forces { shared: bases.iter().map(of).collect(), sorted, squares }
    }

    /// Returns the number of forces.
    pub fn count(&self) -> usize {
        self.sorted.ncols()
    }

    fn shared_by(&self, design: &CandidateDesign) -> Option<&SharedProducts> {
        self.shared.iter().find(|shared| Arc::ptr_eq(&shared.base, &design.base))
    }
}

/// Returns the products of shared columns with others in each part.
fn with_shared(data: &MotionData<'_>, base: &SharedDesign, columns: &DMatrix<f64>) -> Vec<DMatrix<f64>> {
    let product = |(from, samples)| base.rows.columns(from, samples) * columns.rows(from, samples);
    (0..data.parts()).map(|part| product(data.rows_of(part))).collect()
}

/// Returns the products of a few columns with others in each part: for so few columns faster one by one than
/// by blocks.
fn products(data: &MotionData<'_>, few: &DMatrix<f64>, columns: &DMatrix<f64>) -> Vec<DMatrix<f64>> {
    let product = |(from, samples)| few.rows(from, samples).tr_mul(&columns.rows(from, samples));
    (0..data.parts()).map(|part| product(data.rows_of(part))).collect()
}

/// A candidate's columns next to shared ones. Coefficients are ordered: shared, own.
#[derive(Debug, Clone)]
pub(super) struct CandidateDesign {
    base: Arc<SharedDesign>,
    /// Force with all coefficients zero, with samples in the order of the parts, followed by the own columns.
    own: DMatrix<f64>,
    /// Bounds of the candidate's added coefficients, by column.
    bounds: Vec<(usize, f64, f64)>,
    ridge: f64,
    /// Fits without each part; the last with all parts.
    fits: Vec<Border>,
    parts: Vec<PartProducts>,
}

/// Contribution of the own columns to a fit.
#[derive(Debug, Clone)]
struct Border {
    /// U, and the inverse of S, of the module's equation.
    projection: DMatrix<f64>,
    inverse: DMatrix<f64>,
    /// Coefficients of the shared columns for the force with all coefficients zero.
    at_zero: DVector<f64>,
}

/// Products of own columns and zero-coefficient force in a left-out part.
#[derive(Debug, Clone)]
struct PartProducts {
    /// Products of shared and own columns with the zero-coefficient force, its sum of squares, and products
    /// with [`Border::at_zero`].
    shared: DVector<f64>,
    added: DVector<f64>,
    squares: f64,
    gram_products: DVector<f64>,
    /// Products of the own columns' components orthogonal to the shared ones: with the shared columns, and
    /// with themselves.
    across: DMatrix<f64>,
    own: DMatrix<f64>,
}

/// Solution of a design for one force.
#[derive(Debug, Clone)]
pub(super) struct Solved {
    /// Coefficients fitted to all parts.
    pub coefficients: DVector<f64>,
    /// Squared misfit with them, plus their penalty in the same unit.
    pub squares: f64,
}

impl CandidateDesign {
    /// Builds a design from own columns in the order of the records, with a ridge penalty on them. `None`
    /// where columns are linearly dependent.
    pub fn new(
        data: &MotionData<'_>,
        base: &Arc<SharedDesign>,
        shift: &DVector<f64>,
        own: &DMatrix<f64>,
        ridge: f64,
        bounds: Vec<(usize, f64, f64)>,
    ) -> Option<Self> {
        let lengths = lengths(own)?;
        let shift = sorted(data, &DMatrix::from_columns(std::slice::from_ref(shift)));
        let own = sorted(data, own);
        let across = with_shared(data, base, &own);
        let among = products(data, &own, &own);
        let first = |products: Vec<DMatrix<f64>>| {
            products.iter().map(|p| p.column(0).into_owned()).collect::<Vec<DVector<f64>>>()
        };
        let (shared, added) = (first(with_shared(data, base, &shift)), first(products(data, &own, &shift)));
        let (all_across, all_among): (DMatrix<f64>, DMatrix<f64>) = (across.iter().sum(), among.iter().sum());
        let all_shared: DVector<f64> = shared.iter().sum();
        let border = |(fit, normal): (usize, &DMatrix<f64>)| {
            let without = |all: &DMatrix<f64>, parts: &[DMatrix<f64>]| {
                parts.get(fit).map_or_else(|| all.clone(), |part| all - part)
            };
            let across = without(&all_across, &across);
            let projection = normal * &across;
            let left = without(&all_among, &among) - across.tr_mul(&projection);
            let at_zero =
                normal * shared.get(fit).map_or_else(|| all_shared.clone(), |part| &all_shared - part);
            Some(Border {
                inverse: inverse(left, &vec![ridge; lengths.len()], &lengths)?,
                projection,
                at_zero,
            })
        };
        let fits = base.inverses.iter().enumerate().map(border).collect::<Option<Vec<Border>>>()?;
        let parts = fits
            .iter()
            .zip(&base.gram)
            .zip(across.into_iter().zip(among))
            .zip(shared.into_iter().zip(added))
            .enumerate();
        let part = |(at, (((fit, gram), (across, own)), (shared, added)))| {
            let fit: &Border = fit;
            let (from, samples) = data.rows_of(at);
            let of_own: DMatrix<f64> = fit.projection.tr_mul(&across);
            let across: DMatrix<f64> = across - gram * &fit.projection;
            let own = own - of_own - across.tr_mul(&fit.projection);
            let squares = shift.rows(from, samples).norm_squared();
            PartProducts { shared, added, squares, gram_products: gram * &fit.at_zero, across, own }
        };
        let parts = parts.map(part).collect();
        Some(CandidateDesign {
            base: base.clone(),
            own: side_by_side(&[&shift, &own]),
            bounds,
            ridge,
            fits,
            parts,
        })
    }

    /// Fits forces. `None` where an added coefficient leaves its bounds.
    pub fn solve(&self, data: &MotionData<'_>, forces: &Forces) -> Vec<Option<Solved>> {
        let Some(shared) = forces.shared_by(self) else { return vec![None; forces.count()] };
        let (size, count) = (self.base.rows.nrows(), self.own.ncols() - 1);
        // Work with forces subtracted the zero-coefficient force; first subtract its products.
        let products = products(data, &self.own, &forces.sorted);
        let (mut all, mut squares) = (DMatrix::zeros(count, forces.count()), vec![0.0; forces.count()]);
        for (at, (product, part)) in products.iter().zip(&self.parts).enumerate() {
            all += subtracted(&product.rows(1, count).into_owned(), &part.added);
            for (force, squares) in squares.iter_mut().enumerate() {
                *squares += forces.squares[(at, force)] - 2.0 * product[(0, force)] + part.squares;
            }
        }
        let at_zero: DVector<f64> = self.parts.iter().map(|part| &part.shared).sum();
        let whole = &self.fits[data.parts()];
        let sums = subtracted(&shared.sums, &at_zero);
        let own = &whole.inverse * (&all - whole.projection.tr_mul(&sums));
        let first = subtracted(&shared.coefficients[data.parts()], &whole.at_zero) - &whole.projection * &own;
        let solved = |force: usize| {
            let (first, own) = (first.column(force), own.column(force));
            let is_inside = |&(i, lower, upper): &(usize, f64, f64)| (lower..=upper).contains(&own[i - size]);
            let explained = first.dot(&sums.column(force)) + own.dot(&all.column(force));
            self.bounds.iter().all(is_inside).then(|| Solved {
                coefficients: DVector::from_iterator(size + count, first.iter().chain(own.iter()).copied()),
                squares: (squares[force] - explained).max(0.0),
            })
        };
        (0..forces.count()).map(solved).collect()
    }

    /// Predicts each part of the first force from a fit without it: squared errors, part by part.
    pub fn left_out(&self, data: &MotionData<'_>, forces: &Forces) -> Vec<f64> {
        let Some(shared) = forces.shared_by(self) else { return Vec::new() };
        let count = self.own.ncols() - 1;
        let products = products(data, &self.own, &forces.sorted.columns(0, 1).into_owned());
        let at_zero: DVector<f64> = self.parts.iter().map(|part| &part.shared).sum();
        let sums = shared.sums.column(0) - at_zero;
        let mut all = DVector::zeros(count);
        for (product, part) in products.iter().zip(&self.parts) {
            all += product.view((1, 0), (count, 1)).column(0) - &part.added;
        }
        let of_part = |(at, (fit, part)): (usize, (&Border, &PartProducts))| {
            let product = shared.products[at].column(0) - &part.shared;
            let coefficients = shared.coefficients[at].column(0) - &fit.at_zero;
            let gram_products = shared.gram_products[at].column(0) - &part.gram_products;
            let here = products[at].view((1, 0), (count, 1)).column(0) - &part.added;
            let own = &fit.inverse * (&all - &here - fit.projection.tr_mul(&(&sums - &product)));
            let beyond = here - fit.projection.tr_mul(&product) - part.across.tr_mul(&coefficients);
            let squares = forces.squares[(at, 0)] - 2.0 * products[at][(0, 0)] + part.squares;
            let alone = squares + coefficients.dot(&(gram_products - 2.0 * product));
            alone + own.dot(&(&part.own * &own - 2.0 * beyond))
        };
        self.fits.iter().zip(&self.parts).enumerate().map(of_part).collect()
    }

    /// Returns the penalty of coefficients, in the unit of a squared misfit.
    pub fn prior(&self, coefficients: &DVector<f64>) -> f64 {
        let known = self.base.penalty.iter().copied().chain(std::iter::repeat(self.ridge));
        coefficients.iter().zip(known).map(|(c, penalty)| penalty * c * c).sum()
    }

    /// Returns the force with given coefficients, in the order of the records.
    pub fn force(&self, data: &MotionData<'_>, coefficients: &DVector<f64>) -> DVector<f64> {
        let size = self.base.rows.nrows();
        let own = coefficients.rows(size, coefficients.len() - size).insert_row(0, 1.0);
        let sorted = self.base.rows.tr_mul(&coefficients.rows(0, size)) + &self.own * own;
        let mut force = DVector::zeros(sorted.len());
        data.order.iter().zip(sorted.iter()).for_each(|(row, x)| force[*row] = *x);
        force
    }

    /// Returns the covariance of the first coefficients over the variance of the noise, with their penalties
    /// as priors.
    pub fn covariance(&self, count: usize) -> DMatrix<f64> {
        let (Some(inverse), Some(whole)) = (self.base.inverses.last(), self.fits.last()) else {
            return DMatrix::zeros(count, count);
        };
        let projection = whole.projection.rows(0, count);
        inverse.view((0, 0), (count, count)) + projection * &whole.inverse * projection.transpose()
    }
}

/// Subtracts a vector from each column.
fn subtracted(of: &DMatrix<f64>, vector: &DVector<f64>) -> DMatrix<f64> {
    let mut all = of.clone();
    all.column_iter_mut().for_each(|mut column| column -= vector);
    all
}

/// Reorders the samples of columns from the order of the records to that of the parts.
fn sorted(data: &MotionData<'_>, columns: &DMatrix<f64>) -> DMatrix<f64> {
    columns.select_rows(&data.order)
}

/// Returns the lengths of columns; `None` where one is zero or not finite.
fn lengths(columns: &DMatrix<f64>) -> Option<Vec<f64>> {
    columns.column_iter().map(|column| Some(column.norm()).filter(|l| *l > 0.0 && l.is_finite())).collect()
}

/// Least share of its length that a column must have orthogonal to the others to be linearly independent: the
/// resolution of normal equations.
pub(super) const INDEPENDENT: f64 = 1e-5;

/// Inverts penalised normal equations, scaled to columns of unit length for accuracy with mixed units; `None`
/// where columns are linearly dependent.
fn inverse(mut normal: DMatrix<f64>, penalty: &[f64], lengths: &[f64]) -> Option<DMatrix<f64>> {
    let count = normal.nrows();
    for i in 0..count {
        normal[(i, i)] += penalty[i];
    }
    let scaled = DMatrix::from_fn(count, count, |i, j| normal[(i, j)] / (lengths[i] * lengths[j]));
    let inverse =
        Cholesky::new(scaled).filter(|c| (0..count).all(|i| c.l_dirty()[(i, i)] > INDEPENDENT))?.inverse();
    Some(DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] / (lengths[i] * lengths[j])))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use dynamics::inverse_dynamics::{MotionSignal, Preprocessing};
    use measurement::{DriveEffort, MotionRecord};

    /// Bordered columns give the same solution as all columns in one fit, without each part and with all
    /// parts.
    #[test]
    fn limit_bordered_equations_equal_one_fit() {
        let swings = |i: usize| 0.1 * (1e-3 * i as f64).sin();
        let record = MotionRecord {
            name: "sine".into(),
            source: "sine.csv".into(),
            step_s: 1e-3,
            time_s: (0..9000).map(|i| 1e-3 * i as f64).collect(),
            is_angle: false,
            command_m: (0..9000).map(swings).collect(),
            position_m: (0..9000).map(swings).collect(),
            load: DriveEffort::Force(vec![1.0; 9000]),
            others: Default::default(),
        };
        let motion = MotionSignal::new(&record, Preprocessing::default_for(1e-3)).unwrap();
        let data = MotionData::new(vec![&motion]);
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut columns =
            |count: usize| DMatrix::from_fn(data.samples(), count, |_, _| random.random::<f64>() - 0.3);
        for (ridge, count) in [(0.0, 3), (0.2, 7), (0.0, 0)] {
            let (shared, own, shift, forces) = (columns(6), columns(count), columns(1), columns(2));
            let penalty = [vec![0.0; 2], vec![3.0; 4]].concat();
            let base = Arc::new(SharedDesign::new(&data, &shared, penalty.clone()).unwrap());
            let shift = shift.column(0).into_owned();
            let design = CandidateDesign::new(&data, &base, &shift, &own, ridge, Vec::new()).unwrap();
            let forces: Vec<DVector<f64>> = forces.column_iter().map(|c| c.into_owned()).collect();
            let all_forces = Forces::new(&data, &forces, std::slice::from_ref(&base));
            let solved = design.solve(&data, &all_forces);
            let all = side_by_side(&[&shared, &own]);
            let known = DVector::from_iterator(
                6 + count,
                penalty.into_iter().chain(std::iter::repeat_n(ridge, count)),
            );
            for (force, solved) in forces.iter().zip(solved) {
                let (y, solved) = (force - &shift, solved.unwrap());
                let fit = |rows: &[usize]| {
                    let (a, y) = (all.select_rows(rows), y.select_rows(rows));
                    let normal = a.tr_mul(&a) + DMatrix::from_diagonal(&known);
                    (normal.clone().try_inverse().unwrap(), normal.lu().solve(&a.tr_mul(&y)).unwrap())
                };
                let alone = Forces::new(&data, std::slice::from_ref(force), std::slice::from_ref(&base));
                for (part, left) in design.left_out(&data, &alone).iter().enumerate() {
                    let (from, samples) = data.rows_of(part);
                    let (out, kept): (Vec<usize>, Vec<usize>) = (
                        data.order[from..from + samples].to_vec(),
                        data.order[..from].iter().chain(&data.order[from + samples..]).copied().collect(),
                    );
                    let expected =
                        (y.select_rows(&out) - all.select_rows(&out) * fit(&kept).1).norm_squared();
                    assert!((left / expected - 1.0).abs() < 1e-10, "{left} {expected}");
                }
                let (inverse, coefficients) = fit(&data.order);
                assert!((&solved.coefficients - &coefficients).norm() < 1e-10 * coefficients.norm());
                let prior = coefficients.component_mul(&coefficients).dot(&known);
                assert!((design.prior(&solved.coefficients) - prior).abs() <= 1e-9 * prior);
                let squares = (&y - &all * &coefficients).norm_squared() + prior;
                assert!((solved.squares / squares - 1.0).abs() < 1e-9, "{} {squares}", solved.squares);
                assert!(
                    (design.covariance(6) - inverse.view((0, 0), (6, 6))).norm() < 1e-10 * inverse.norm()
                );
                assert!(
                    (design.force(&data, &coefficients) - &all * &coefficients - &shift).norm()
                        < 1e-10 * force.norm()
                );
            }
        }
    }
}
