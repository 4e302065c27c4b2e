//! Joint fit of two tests of one machine, to first order about the minima of their own fits.

use nalgebra::{DMatrix, DVector};

use machine::Machine;
use report::certainty::{CoordinateRow, PosteriorRow, ResidualRow};

/// Relative scatter (1) of a natural frequency between two tests of an unchanged machine, where `modes.csv`
/// states none: 0.1 % by reading, as repeats of hammer tests show, and 0.15 % by 10 K of temperature, since
/// the modulus of steel falls by 0.03 % per kelvin.
pub(crate) const ASSUMED_SCATTER: f64 = 0.002;
/// Inverse variance of an even distribution over the unit interval (1).
const RANGE_PRECISION: f64 = 12.0;

/// The joint fit of two results of one machine.
///
/// What both tests share cancels in a change: tolerances of the machine, and the error of the model. A
/// measured frequency differs from its prediction by e = m + s, the model's error m and the scatter s of the
/// reading. Two tests with the same description and the same position have the same m in the frequency of an
/// order, as long as the machine is the same, and independent s. For each such frequency m is therefore an
/// unknown common to both, with the prior N(0, σ_m²) of the model error, and the two residuals have the
/// variances of their scatter alone:
///
/// e_a = J_a·δθ_a + m + s_a,  e_b = J_b·δθ_b + m + s_b  ⇒  cov(e_a, e_b) = σ_m²
///
/// A misfit beyond the stated uncertainty belongs to the model, too, as far as both fits show it; the rest
/// counts in its own test. Frequencies without a partner, amplitudes and whole FRFs count with their whole
/// variance in each test.
///
/// # Source  model discrepancy as an unknown with a prior: Kennedy and O'Hagan, J. R. Stat. Soc. B 63 (2001)
///   425–464; residuals of the same origin in two models: Zellner, J. Am. Stat. Assoc. 57 (1962) 348–368.
pub(crate) struct Joint<'r> {
    /// Parameters that are fitted in both: id, index in the machine.
    pub own: Vec<(String, usize)>,
    /// Common tolerances: name, standard deviation and centre of the prior in the unit interval.
    pub common: Vec<(String, f64, f64)>,
    tests: [Test<'r>; 2],
    /// Number of unknowns.
    size: usize,
}

/// One of the two results.
struct Test<'r> {
    posterior: &'r PosteriorRow,
    /// Column of the joint state of each coordinate.
    columns: Vec<usize>,
    /// Column and standard deviation of the common model error of each residual; `None` where it is its own.
    errors: Vec<Option<(usize, f64)>>,
    /// Inverse covariance; `None` where it is singular.
    precision: Option<DMatrix<f64>>,
}

/// Whether a residual compares a frequency whose scatter is assumed.
fn is_scatter_assumed(residual: &ResidualRow) -> bool {
    residual.order.is_some() && !residual.scatter_stated
}

/// Returns the variance of a residual by its measurement alone.
fn scatter_variance(residual: &ResidualRow) -> f64 {
    let assumed = if is_scatter_assumed(residual) { ASSUMED_SCATTER } else { 0.0 };
    residual.scatter_sd.powi(2) + assumed.powi(2)
}

/// Returns the whole variance of a residual, by model and measurement.
fn variance(residual: &ResidualRow, of: &PosteriorRow) -> f64 {
    of.variance * (residual.model_sd.powi(2) + residual.scatter_sd.powi(2))
}

/// Whether two residuals compare the same mode at the same place of the machine.
fn is_same_mode(a: &ResidualRow, b: &ResidualRow) -> bool {
    let same_place = match (a.nut_m, b.nut_m) {
        (Some(x), Some(y)) => x == y,
        _ => a.position == b.position,
    };
    a.order.is_some() && a.order == b.order && same_place
}

impl<'r> Joint<'r> {
    pub fn new(machine: &Machine, a: &'r PosteriorRow, b: &'r PosteriorRow) -> Self {
        let names = |of: &PosteriorRow| of.coordinates.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
        let (in_a, in_b) = (names(a), names(b));
        let own: Vec<(String, usize)> = in_a
            .iter()
            .filter(|id| in_b.contains(id))
            .filter_map(|id| Some((id.clone(), machine.parameter(id)?)))
            .collect();
        let tolerance = |c: &CoordinateRow| {
            let [centre, sd] = c.prior.filter(|_| c.of_machine && machine.parameter(&c.name).is_none())?;
            in_b.contains(&c.name).then(|| (c.name.clone(), sd, centre))
        };
        let common: Vec<(String, f64, f64)> = a.coordinates.iter().filter_map(tolerance).collect();
        // Joint state: own parameters of the first and of the second result, common tolerances, then what
        // belongs to one of them, then common model errors.
        let mut size = 2 * own.len() + common.len();
        let mut columns = |names: &[String], which: usize| -> Vec<usize> {
            let column = |name: &String| {
                let of_own = own.iter().position(|(id, _)| id == name).map(|at| which * own.len() + at);
                let of_common = common.iter().position(|(id, _, _)| id == name).map(|at| 2 * own.len() + at);
                of_own.or(of_common).unwrap_or_else(|| {
                    size += 1;
                    size - 1
                })
            };
            names.iter().map(column).collect()
        };
        let columns = [columns(&in_a, 0), columns(&in_b, 1)];
        let mut errors = [a, b].map(|of| vec![None; of.residuals.len()]);
        for (at, x) in a.residuals.iter().enumerate() {
            let Some(partner) = b.residuals.iter().position(|y| is_same_mode(x, y)) else { continue };
            let of_model = |r: &ResidualRow, of| variance(r, of) - scatter_variance(r);
            let common = of_model(x, a).min(of_model(&b.residuals[partner], b));
            if common > 0.0 {
                errors[0][at] = Some((size, common.sqrt()));
                errors[1][partner] = Some((size, common.sqrt()));
                size += 1;
            }
        }
        let [of_a, of_b] = columns;
        let [errors_a, errors_b] = errors;
        let test = |posterior: &'r PosteriorRow, columns, errors| {
            let count = posterior.coordinates.len();
            let entry = |row: usize, column: usize| posterior.covariance[row.max(column)][row.min(column)];
            let precision = DMatrix::from_fn(count, count, entry).try_inverse();
            Test { posterior, columns, errors, precision }
        };
        Joint { own, common, tests: [test(a, of_a, errors_a), test(b, of_b, errors_b)], size }
    }

    /// Returns the number of frequencies whose model error is common to both tests.
    pub fn common_errors(&self) -> usize {
        self.tests[0].errors.iter().flatten().count()
    }

    /// Returns the number of these frequencies whose scatter is assumed, of each test.
    pub fn assumed_scatters(&self) -> [usize; 2] {
        let count = |test: &Test<'_>| {
            let residuals = test.posterior.residuals.iter().zip(&test.errors);
            residuals.filter(|(residual, error)| error.is_some() && is_scatter_assumed(residual)).count()
        };
        [count(&self.tests[0]), count(&self.tests[1])]
    }

    /// Computes the change of each own parameter, and its standard deviation, between two minima. `None`
    /// where a covariance is singular.
    ///
    /// Residuals of common modes that differ by more than their scatter widen the intervals.
    ///
    /// # Source  Birge, Phys. Rev. 40 (1932) 207–227
    pub fn changes(&self, minima: [usize; 2]) -> Option<Vec<(f64, f64)>> {
        let mut system = System::new(self.size);
        for (test, minimum) in self.tests.iter().zip(minima) {
            match test.posterior.residuals.is_empty() {
                true => system.add_parabola(test, minimum, 2 * self.own.len())?,
                false => system.add_residuals(test, minimum, 2 * self.own.len()),
            }
        }
        for (at, (_, sd, centre)) in self.common.iter().enumerate() {
            system.add_prior(2 * self.own.len() + at, -1.0 / (sd * sd), *centre);
        }
        for (error, _) in self.tests[0].errors.iter().flatten() {
            system.add_prior(*error, 1.0, 0.0);
        }
        let covariance: DMatrix<f64> = system.information.clone().try_inverse()?;
        let state: DVector<f64> = &covariance * &system.target;
        let excess = system.excess(&state, &covariance);
        let count = self.own.len();
        let change = |at: usize| {
            let variance = covariance[(at, at)] + covariance[(count + at, count + at)]
                - 2.0 * covariance[(at, count + at)];
            (state[count + at] - state[at], (excess * variance).max(0.0).sqrt())
        };
        Some((0..count).map(change).collect())
    }
}

/// Normal equations of the joint fit.
struct System {
    information: DMatrix<f64>,
    target: DVector<f64>,
    /// Residuals with a common model error: their derivatives and values at a state of 0, each over its
    /// standard deviation by scatter.
    compared: Vec<(Vec<(usize, f64)>, f64)>,
}

impl System {
    fn new(size: usize) -> Self {
        System { information: DMatrix::zeros(size, size), target: DVector::zeros(size), compared: Vec::new() }
    }

    fn add_prior(&mut self, column: usize, precision: f64, centre: f64) {
        self.information[(column, column)] += precision;
        self.target[column] += precision * centre;
    }

    /// Adds a result by minimum and covariance, without the priors of its parameters, the first `own` columns:
    /// they say nothing about a change.
    fn add_parabola(&mut self, test: &Test<'_>, minimum: usize, own: usize) -> Option<()> {
        let precision = test.precision.as_ref()?;
        let pull = precision * DVector::from_row_slice(&test.posterior.minima[minimum]);
        for (row, i) in test.columns.iter().enumerate() {
            self.target[*i] += pull[row];
            let columns = test.columns.iter().enumerate();
            columns.for_each(|(column, j)| self.information[(*i, *j)] += precision[(row, column)]);
        }
        let coordinates = test.columns.iter().zip(&test.posterior.coordinates);
        for (column, [centre, sd]) in coordinates.filter_map(|(column, c)| Some((*column, c.prior?))) {
            if column < own {
                self.add_prior(column, -1.0 / (sd * sd), centre);
            }
        }
        Some(())
    }

    /// Adds a result by its residuals, priors, and the ranges of its parameters, the first `own` columns.
    fn add_residuals(&mut self, test: &Test<'_>, minimum: usize, own: usize) {
        let of = test.posterior;
        let place = &of.minima[minimum];
        for ((column, coordinate), u) in test.columns.iter().zip(&of.coordinates).zip(place) {
            let (centre, precision) = match coordinate.prior.filter(|_| *column >= own) {
                Some([centre, sd]) => (centre, 1.0 / (sd * sd)),
                None => (*u, RANGE_PRECISION),
            };
            self.add_prior(*column, precision, centre);
        }
        for (residual, error) in of.residuals.iter().zip(&test.errors) {
            let common = error.map_or(0.0, |(_, sd)| sd);
            let sd = (variance(residual, of) - common * common).sqrt();
            let slopes = test.columns.iter().copied().zip(residual.slopes.iter().map(|slope| slope / sd));
            let entries: Vec<(usize, f64)> =
                slopes.chain(error.map(|(column, by)| (column, by / sd))).filter(|e| e.1 != 0.0).collect();
            let here: f64 = place.iter().zip(&residual.slopes).map(|(u, slope)| u * slope / sd).sum();
            let value = residual.deviations[minimum] / sd - here;
            for (i, x) in &entries {
                self.target[*i] -= x * value;
                entries.iter().for_each(|(j, y)| self.information[(*i, *j)] += x * y);
            }
            if error.is_some() {
                self.compared.push((entries, value));
            }
        }
    }

    /// Returns the factor of the variance by which compared residuals exceed their scatter at a solution, at
    /// least 1. Of n residuals the solution uses up as many degrees of freedom as the sum of their leverages.
    fn excess(&self, state: &DVector<f64>, covariance: &DMatrix<f64>) -> f64 {
        let (mut chi_square, mut freedom) = (0.0, 0.0);
        for (entries, value) in &self.compared {
            chi_square += (value + entries.iter().map(|(i, x)| x * state[*i]).sum::<f64>()).powi(2);
            let of = |(i, x): &(usize, f64)| {
                entries.iter().map(|(j, y)| x * y * covariance[(*i, *j)]).sum::<f64>()
            };
            freedom += 1.0 - entries.iter().map(of).sum::<f64>();
        }
        if freedom >= 1.0 { (chi_square / freedom).max(1.0) } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coordinate(name: &str, prior: Option<[f64; 2]>) -> CoordinateRow {
        CoordinateRow { name: name.into(), of_machine: true, prior }
    }

    /// One parameter and one common tolerance t ~ N(0.5, 0.1): each result measures θ + t alone, to 0.01.
    fn result(sum: f64) -> PosteriorRow {
        let (measured, prior, range) = (1e4, 1e2, 12.0);
        let information =
            DMatrix::from_row_slice(2, 2, &[measured + range, measured, measured, measured + prior]);
        let covariance = information.try_inverse().unwrap();
        PosteriorRow {
            coordinates: vec![coordinate("k_n", None), coordinate("mass of table", Some([0.5, 0.1]))],
            minima: vec![vec![sum - 0.5, 0.5]],
            covariance: (0..2)
                .map(|row| (0..=row).map(|column| covariance[(row, column)]).collect())
                .collect(),
            variance: 1.0,
            residuals: Vec::new(),
        }
    }

    /// The same measurement as a frequency: its scatter is 0.001, the error of the model 0.01.
    fn measured(sum: f64) -> PosteriorRow {
        let residual = ResidualRow {
            position: "p".into(),
            nut_m: None,
            order: Some(1),
            model_sd: 0.01,
            scatter_sd: 0.001,
            scatter_stated: true,
            deviations: vec![0.0],
            slopes: vec![1.0, 1.0],
        };
        PosteriorRow { residuals: vec![residual], ..result(sum) }
    }

    fn change(first: &PosteriorRow, second: &PosteriorRow) -> (f64, f64) {
        let machine = crate::read_machine("configs/tian.toml").unwrap().machine;
        Joint::new(&machine, first, second).changes([0, 0]).unwrap()[0]
    }

    #[test]
    fn limit_common_tolerances_do_not_count_as_a_difference() {
        let (change, sd) = change(&result(0.9), &result(0.95));
        // θ alone is known to 0.1, its change to √2·0.01.
        assert!((change - 0.05).abs() < 2e-3 && (sd - 2_f64.sqrt() * 0.01).abs() < 5e-4, "{change} ± {sd}");
    }

    /// The change has the scatter of the two readings, whatever the error of the model.
    #[test]
    fn limit_the_common_error_of_the_model_does_not_count_as_a_difference() {
        let (found, sd) = change(&measured(0.9), &measured(0.95));
        assert!((found - 0.05).abs() < 1e-4 && (sd - 2_f64.sqrt() * 1e-3).abs() < 1e-5, "{found} ± {sd}");
        // Of another mode it is another error.
        let mut other = measured(0.95);
        other.residuals[0].order = Some(2);
        let sd = change(&measured(0.9), &other).1;
        assert!((sd - 2_f64.sqrt() * 0.01).abs() < 5e-4, "{sd}");
    }
}
