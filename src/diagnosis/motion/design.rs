//! Least squares of candidates beside columns that they share. All that does not depend on the recorded force is worked out beforehand, nulls are solved
//! together, and a candidate keeps what it adds alone: its columns border the normal equations of those shared.
//!
//! ```text
//! ┌ A   B ┐ ┌c┐   ┌a┐      U = A⁻¹·B     S = C − Bᵀ·U      z = S⁻¹·(b − Uᵀ·a)      c = A⁻¹·a − U·z
//! └ Bᵀ  C ┘ └z┘ = └b┘
//! ```
//!
//! # Source  the inverse of a bordered matrix: Golub and Van Loan, Matrix Computations, 4th ed. (2013), 3.2.11.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::data::{MotionData, beside};

/// Columns that designs share, with what is known of their coefficients.
#[derive(Debug)]
pub(super) struct SharedDesign {
    /// Columns, each a row, their samples in the order of the parts.
    rows: DMatrix<f64>,
    penalty: Vec<f64>,
    /// Products of the columns in each part.
    gram: Vec<DMatrix<f64>>,
    /// Inverses of the normal equations without each part, and last with all.
    inverses: Vec<DMatrix<f64>>,
}

impl SharedDesign {
    /// Of columns in the order of the records. `penalty` is added to the diagonal of the normal equations, column by column: 0, or the noise's variance over
    /// that of the coefficient. `None` where columns are not independent.
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
        let inverses: Option<Vec<DMatrix<f64>>> = gram.iter().map(|part| &all - part).chain([all.clone()]).map(inverse).collect();
        Some(SharedDesign { inverses: inverses?, rows, penalty, gram })
    }
}

/// Forces to be fitted, one recorded or many drawn, with what fits beside shared columns make of them; one force a column.
pub(super) struct Forces {
    /// Their samples in the order of the parts that are left out.
    sorted: DMatrix<f64>,
    /// Sum of squares of each part (row).
    squares: DMatrix<f64>,
    beside: Vec<SharedProducts>,
}

/// Products with shared columns in each part and in all, and coefficients of each fit of them alone; those times the products of the part left out.
struct SharedProducts {
    base: Arc<SharedDesign>,
    products: Vec<DMatrix<f64>>,
    sums: DMatrix<f64>,
    coefficients: Vec<DMatrix<f64>>,
    bent: Vec<DMatrix<f64>>,
}

impl Forces {
    /// Of forces in the order of the records, for designs beside some columns.
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
            let coefficients: Vec<DMatrix<f64>> = base.inverses.iter().zip(rests).map(|(inverse, rest)| inverse * rest).collect();
            let bent = base.gram.iter().zip(&coefficients).map(|(gram, c)| gram * c).collect();
            SharedProducts { base: base.clone(), products, sums, coefficients, bent }
        };
        Forces { beside: bases.iter().map(of).collect(), sorted, squares }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.sorted.ncols()
    }
}

/// Products of shared columns with others in each part.
fn with_shared(data: &MotionData<'_>, base: &SharedDesign, columns: &DMatrix<f64>) -> Vec<DMatrix<f64>> {
    let product = |(from, samples)| base.rows.columns(from, samples) * columns.rows(from, samples);
    (0..data.parts()).map(|part| product(data.rows_of(part))).collect()
}

/// Products of a few columns with others in each part: one after another, which for so few is faster than by blocks.
fn products(data: &MotionData<'_>, few: &DMatrix<f64>, columns: &DMatrix<f64>) -> Vec<DMatrix<f64>> {
    let product = |(from, samples)| few.rows(from, samples).tr_mul(&columns.rows(from, samples));
    (0..data.parts()).map(|part| product(data.rows_of(part))).collect()
}

/// Linear columns beside shared ones. Coefficients stand in this order: shared, own.
#[derive(Debug, Clone)]
pub(super) struct CandidateDesign {
    base: Arc<SharedDesign>,
    /// Force with all coefficients at nothing, its samples in the order of the parts; and beside it the own columns.
    own: DMatrix<f64>,
    /// Ends of the coefficients that the candidate adds, by column.
    bounds: Vec<(usize, f64, f64)>,
    ridge: f64,
    /// Fits without each part, and last with all.
    fits: Vec<Border>,
    parts: Vec<PartProducts>,
}

/// What the own columns add to a fit.
#[derive(Debug, Clone)]
struct Border {
    /// U, and the inverse of S.
    stand_for: DMatrix<f64>,
    inverse: DMatrix<f64>,
    /// Coefficients of the shared columns for the force at nothing.
    nothing: DVector<f64>,
}

/// What the own columns and the force at nothing are in a part that is left out.
#[derive(Debug, Clone)]
struct PartProducts {
    /// Products of shared and own columns with the force at nothing, its squares; products with [`Border::nothing`].
    shared: DVector<f64>,
    added: DVector<f64>,
    squares: f64,
    bent: DVector<f64>,
    /// Products of what the shared columns do not stand for of the own: with the shared, and with itself.
    across: DMatrix<f64>,
    own: DMatrix<f64>,
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

impl CandidateDesign {
    /// With own columns in the order of the records, and a ridge that keeps them apart. `None` where columns are not independent.
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
        let first = |products: Vec<DMatrix<f64>>| products.iter().map(|p| p.column(0).into_owned()).collect::<Vec<DVector<f64>>>();
        let (shared, added) = (first(with_shared(data, base, &shift)), first(products(data, &own, &shift)));
        let (all_across, all_among): (DMatrix<f64>, DMatrix<f64>) = (across.iter().sum(), among.iter().sum());
        let all_shared: DVector<f64> = shared.iter().sum();
        let border = |(fit, normal): (usize, &DMatrix<f64>)| {
            let without = |all: &DMatrix<f64>, parts: &[DMatrix<f64>]| parts.get(fit).map_or_else(|| all.clone(), |part| all - part);
            let across = without(&all_across, &across);
            let stand_for = normal * &across;
            let left = without(&all_among, &among) - across.tr_mul(&stand_for);
            let nothing = normal * shared.get(fit).map_or_else(|| all_shared.clone(), |part| &all_shared - part);
            Some(Border { inverse: inverse(left, &vec![ridge; lengths.len()], &lengths)?, stand_for, nothing })
        };
        let fits = base.inverses.iter().enumerate().map(border).collect::<Option<Vec<Border>>>()?;
        let parts = fits.iter().zip(&base.gram).zip(across.into_iter().zip(among)).zip(shared.into_iter().zip(added)).enumerate();
        let part = |(at, (((fit, gram), (across, own)), (shared, added)))| {
            let fit: &Border = fit;
            let (from, samples) = data.rows_of(at);
            let of_own: DMatrix<f64> = fit.stand_for.tr_mul(&across);
            let across: DMatrix<f64> = across - gram * &fit.stand_for;
            let own = own - of_own - across.tr_mul(&fit.stand_for);
            let squares = shift.rows(from, samples).norm_squared();
            PartProducts { shared, added, squares, bent: gram * &fit.nothing, across, own }
        };
        let parts = parts.map(part).collect();
        Some(CandidateDesign { base: base.clone(), own: beside(&[&shift, &own]), bounds, ridge, fits, parts })
    }

    /// Fits forces, and foretells each part from a fit without it. `None` where what the candidate adds would leave its range.
    pub fn solve(&self, data: &MotionData<'_>, forces: &Forces) -> Vec<Option<Solved>> {
        let Some(shared) = forces.beside.iter().find(|b| Arc::ptr_eq(&b.base, &self.base)) else { return vec![None; forces.count()] };
        let (size, count) = (self.base.rows.nrows(), self.own.ncols() - 1);
        // Of what each force is beyond the force at nothing: first its product with that.
        let mut products = products(data, &self.own, &forces.sorted);
        let mut all = DMatrix::zeros(count, forces.count());
        for (product, part) in products.iter_mut().zip(&self.parts) {
            product.rows_mut(1, count).column_iter_mut().for_each(|mut column| column -= &part.added);
            all += product.rows(1, count);
        }
        let nothing: DVector<f64> = self.parts.iter().map(|part| &part.shared).sum();
        let whole = &self.fits[data.parts()];
        let sums = less(&shared.sums, &nothing);
        let own = &whole.inverse * (&all - whole.stand_for.tr_mul(&sums));
        let first = less(&shared.coefficients[data.parts()], &whole.nothing) - &whole.stand_for * &own;
        let inside = |at: &usize| self.bounds.iter().all(|&(i, lower, upper)| (lower..=upper).contains(&own[(i - size, *at)]));
        let inside: Vec<usize> = (0..forces.count()).filter(inside).collect();
        let mut solved = vec![None; forces.count()];
        for &at in &inside {
            let coefficients = DVector::from_iterator(size + count, first.column(at).iter().chain(own.column(at).iter()).copied());
            let known = self.base.penalty.iter().copied().chain(std::iter::repeat_n(self.ridge, count));
            let prior = coefficients.iter().zip(known).map(|(c, p)| p * c * c).sum();
            solved[at] = Some(Solved { coefficients, left_out: Vec::with_capacity(data.parts()), prior });
        }
        let all = all.select_columns(&inside);
        let sums = sums.select_columns(&inside);
        for (at, (fit, part)) in self.fits.iter().zip(&self.parts).enumerate() {
            let chosen = |of: &DMatrix<f64>, nothing: &DVector<f64>| less(&of.select_columns(&inside), nothing);
            let product = chosen(&shared.products[at], &part.shared);
            let coefficients = chosen(&shared.coefficients[at], &fit.nothing);
            let bent = chosen(&shared.bent[at], &part.bent);
            let own_product = products[at].select_columns(&inside);
            let here = own_product.rows(1, count);
            let own = &fit.inverse * (&all - here - fit.stand_for.tr_mul(&(&sums - &product)));
            let beyond = here - fit.stand_for.tr_mul(&product) - part.across.tr_mul(&coefficients);
            let bent_own = &part.own * &own;
            for (k, force) in inside.iter().enumerate() {
                let squares = forces.squares[(at, *force)] - 2.0 * own_product[(0, k)] + part.squares;
                let alone = squares + coefficients.column(k).dot(&(bent.column(k) - 2.0 * product.column(k)));
                let left = alone + own.column(k).dot(&(bent_own.column(k) - 2.0 * beyond.column(k)));
                if let Some(solved) = &mut solved[*force] {
                    solved.left_out.push(left);
                }
            }
        }
        solved
    }

    /// The force with these coefficients, in the order of the records.
    pub fn force(&self, data: &MotionData<'_>, coefficients: &DVector<f64>) -> DVector<f64> {
        let size = self.base.rows.nrows();
        let own = coefficients.rows(size, coefficients.len() - size).insert_row(0, 1.0);
        let sorted = self.base.rows.tr_mul(&coefficients.rows(0, size)) + &self.own * own;
        let mut force = DVector::zeros(sorted.len());
        data.order.iter().zip(sorted.iter()).for_each(|(row, x)| force[*row] = *x);
        force
    }

    /// Covariance of the first coefficients over the variance of the noise, where all is known of them that their penalty says.
    pub fn covariance(&self, count: usize) -> DMatrix<f64> {
        let (Some(inverse), Some(whole)) = (self.base.inverses.last(), self.fits.last()) else { return DMatrix::zeros(count, count) };
        let stand_for = whole.stand_for.rows(0, count);
        inverse.view((0, 0), (count, count)) + stand_for * &whole.inverse * stand_for.transpose()
    }
}

/// The columns of a matrix, less a vector.
fn less(of: &DMatrix<f64>, vector: &DVector<f64>) -> DMatrix<f64> {
    let mut all = of.clone();
    all.column_iter_mut().for_each(|mut column| column -= vector);
    all
}

/// Columns in the order of the records, their samples put in the order of the parts.
fn sorted(data: &MotionData<'_>, columns: &DMatrix<f64>) -> DMatrix<f64> {
    columns.select_rows(&data.order)
}

/// Lengths of columns; `None` where one has none.
fn lengths(columns: &DMatrix<f64>) -> Option<Vec<f64>> {
    columns.column_iter().map(|column| Some(column.norm()).filter(|l| *l > 0.0 && l.is_finite())).collect()
}

/// Share of its length below which a column is taken for a combination of the others: normal equations know no less.
pub(super) const INDEPENDENT: f64 = 1e-5;

/// Inverse of normal equations with a penalty, through columns of length one, so that it is exact where units differ; `None` where columns are not
/// independent.
fn inverse(mut normal: DMatrix<f64>, penalty: &[f64], lengths: &[f64]) -> Option<DMatrix<f64>> {
    let count = normal.nrows();
    for i in 0..count {
        normal[(i, i)] += penalty[i];
    }
    let scaled = DMatrix::from_fn(count, count, |i, j| normal[(i, j)] / (lengths[i] * lengths[j]));
    let inverse = Cholesky::new(scaled).filter(|c| (0..count).all(|i| c.l_dirty()[(i, i)] > INDEPENDENT))?.inverse();
    Some(DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] / (lengths[i] * lengths[j])))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use dynamics::inverse_dynamics::{MotionSignal, Preprocessing};
    use measurement::{DriveEffort, MotionRecord};

    /// Columns that border those shared are columns as all others: fits of every column at once, without each part and with all, say the same.
    #[test]
    fn limit_bordered_is_the_whole() {
        let swings = |i: usize| 0.1 * (1e-3 * i as f64).sin();
        let record = MotionRecord {
            name: "sine".into(),
            source: "sine.csv".into(),
            step_s: 1e-3,
            time_s: (0..9000).map(|i| 1e-3 * i as f64).collect(),
            command_m: (0..9000).map(swings).collect(),
            position_m: (0..9000).map(swings).collect(),
            load: DriveEffort::Force(vec![1.0; 9000]),
            others: Default::default(),
        };
        let motion = MotionSignal::new(&record, Preprocessing::usual(1e-3)).unwrap();
        let data = MotionData::new(vec![&motion]);
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut columns = |count: usize| DMatrix::from_fn(data.samples(), count, |_, _| random.random::<f64>() - 0.3);
        for (ridge, count) in [(0.0, 3), (0.2, 7), (0.0, 0)] {
            let (shared, own, shift, forces) = (columns(6), columns(count), columns(1), columns(2));
            let penalty = [vec![0.0; 2], vec![3.0; 4]].concat();
            let base = Arc::new(SharedDesign::new(&data, &shared, penalty.clone()).unwrap());
            let shift = shift.column(0).into_owned();
            let design = CandidateDesign::new(&data, &base, &shift, &own, ridge, Vec::new()).unwrap();
            let forces: Vec<DVector<f64>> = forces.column_iter().map(|c| c.into_owned()).collect();
            let solved = design.solve(&data, &Forces::new(&data, &forces, &[base]));
            let all = beside(&[&shared, &own]);
            let known = DVector::from_iterator(6 + count, penalty.into_iter().chain(std::iter::repeat_n(ridge, count)));
            for (force, solved) in forces.iter().zip(solved) {
                let (y, solved) = (force - &shift, solved.unwrap());
                let fit = |rows: &[usize]| {
                    let (a, y) = (all.select_rows(rows), y.select_rows(rows));
                    let normal = a.tr_mul(&a) + DMatrix::from_diagonal(&known);
                    (normal.clone().try_inverse().unwrap(), normal.lu().solve(&a.tr_mul(&y)).unwrap())
                };
                for (part, left) in solved.left_out.iter().enumerate() {
                    let (from, samples) = data.rows_of(part);
                    let (out, kept): (Vec<usize>, Vec<usize>) = (
                        data.order[from..from + samples].to_vec(),
                        data.order[..from].iter().chain(&data.order[from + samples..]).copied().collect(),
                    );
                    let expected = (y.select_rows(&out) - all.select_rows(&out) * fit(&kept).1).norm_squared();
                    assert!((left / expected - 1.0).abs() < 1e-10, "{left} {expected}");
                }
                let (inverse, coefficients) = fit(&data.order);
                assert!((&solved.coefficients - &coefficients).norm() < 1e-10 * coefficients.norm());
                assert!((solved.prior - coefficients.component_mul(&coefficients).dot(&known)).abs() < 1e-10);
                assert!((design.covariance(6) - inverse.view((0, 0), (6, 6))).norm() < 1e-10 * inverse.norm());
                assert!((design.force(&data, &coefficients) - &all * &coefficients - &shift).norm() < 1e-10 * force.norm());
            }
        }
    }
}
