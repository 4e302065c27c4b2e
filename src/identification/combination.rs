//! Combinations of two parameters that the data determine better than the parameters themselves.

use rayon::prelude::*;

use super::uncertainty::Certainty;
use machine::{Parameter, Scale};

/// How two parameters compensate each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CombinationKind {
    /// Like springs in series: 1/a + 1/b is determined.
    Series,
    /// Like springs or dampers in parallel: a + b is determined.
    Parallel,
    /// One rises as the other falls.
    Opposite,
    /// Both rise together: their ratio is determined.
    Ratio,
}

/// Two parameters whose combination the data determine better than either of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Combination {
    /// Indices of the two parameters.
    pub parameters: (usize, usize),
    /// How they compensate each other.
    pub kind: CombinationKind,
    /// Their correlation.
    pub correlation: f64,
    /// Relative standard deviation of the combination.
    pub sd: f64,
    /// Description for the user.
    pub text: String,
}

/// Least magnitude of the correlation (1) at which two parameters are reported together.
const CORRELATED: f64 = 0.9;
/// Relative standard deviation (1) at and above which a combination is not reported.
const MAX_SD: f64 = 0.25;
/// Moves along a valley of χ², tried from the largest, as shares of a parameter's unit interval.
const MOVES: [f64; 3] = [0.5, 0.25, 0.1];

/// Finds the determined combinations among the parameters of the columns, in the order of rising standard
/// deviation. `known` marks the parameters whose values the data determine to first order.
///
/// `valley(column, by)` moves a column by a share of its unit interval, re-optimises the others and returns
/// the values of all columns. It returns `None` where χ² rises too much.
pub fn combinations(
    parameters: &[&Parameter],
    values: &[f64],
    (certainty, known): (&Certainty, &[bool]),
    valley: impl Fn(usize, f64) -> Option<Vec<f64>> + Sync,
) -> Vec<Combination> {
    let is_candidate = |&(j, i): &(usize, usize)| {
        !(known[i] && known[j]) && [i, j].iter().all(|k| parameters[*k].scale == Scale::Logarithmic)
    };
    let pairs: Vec<(usize, usize)> =
        (0..parameters.len()).flat_map(|i| (0..i).map(move |j| (j, i))).filter(is_candidate).collect();
    let of_pair = |&(j, i): &(usize, usize)| {
        // In a strongly curved valley correlations mean nothing, for example if one of two springs in series
        // is nearly rigid.
        let kind = parameters[i]
            .is_like(parameters[j])
            .then(|| constant_sum((j, i), values, certainty, &valley))
            .flatten();
        let is_reported = kind.is_some() || certainty.correlation[i][j].abs() >= CORRELATED;
        is_reported.then(|| combination(parameters, values, certainty, (j, i), kind))
    };
    let mut found: Vec<Combination> = pairs.par_iter().filter_map(of_pair).collect();
    found.retain(|c| c.sd < MAX_SD);
    found.sort_by(|a, b| a.sd.total_cmp(&b.sd));
    found
}

/// Returns the sum and the harmonic sum (springs in series) of two values.
fn sums(a: f64, b: f64) -> (f64, f64) {
    (a + b, a * b / (a + b))
}

/// Determines whether the sum or the harmonic sum stays constant along the valley, and its remaining relative
/// change.
///
/// The change is at most a fifth of that of the values, and at most a quarter of that of the other sum. For
/// equal values both sums agree to first order, so that only a finite move distinguishes them.
fn constant_sum(
    (i, j): (usize, usize),
    values: &[f64],
    certainty: &Certainty,
    valley: &(impl Fn(usize, f64) -> Option<Vec<f64>> + Sync),
) -> Option<(CombinationKind, f64)> {
    let here = sums(values[i], values[j]);
    let (mut moved, mut sum, mut harmonic) = (0.0_f64, 0.0_f64, 0.0_f64);
    // Move the less certain parameter; the other is re-optimised.
    let column = if certainty.sd[i] >= certainty.sd[j] { i } else { j };
    let farthest = |sign: f64| MOVES.into_iter().find_map(|by| valley(column, sign * by));
    let (up, down) = rayon::join(|| farthest(1.0), || farthest(-1.0));
    for there in [up, down].into_iter().flatten() {
        let now = sums(there[i], there[j]);
        moved = moved.max((there[i] / values[i]).ln().abs().min((there[j] / values[j]).ln().abs()));
        sum = sum.max((now.0 / here.0).ln().abs());
        harmonic = harmonic.max((now.1 / here.1).ln().abs());
    }
    let is_constant = |own: f64, other: f64| moved > 0.02 && own < 0.2 * moved && own < 0.25 * other;
    if is_constant(harmonic, sum) {
        Some((CombinationKind::Series, harmonic))
    } else {
        is_constant(sum, harmonic).then_some((CombinationKind::Parallel, sum))
    }
}

fn combination(
    parameters: &[&Parameter],
    values: &[f64],
    certainty: &Certainty,
    (i, j): (usize, usize),
    constant: Option<(CombinationKind, f64)>,
) -> Combination {
    // Covariance of the logarithms.
    let width = |k: usize| (parameters[k].upper / parameters[k].lower).ln();
    let entry = |a: usize, b: usize| certainty.covariance[(a, b)] * width(a) * width(b);
    let (vi, vj, cij) = (entry(i, i), entry(j, j), entry(i, j));
    let correlation = certainty.correlation[i][j];
    let (a, b) = (values[i], values[j]);
    // Relative standard deviation of wᵢ·ln a + wⱼ·ln b.
    let spread_of = |wi: f64, wj: f64| (wi * wi * vi + wj * wj * vj + 2.0 * wi * wj * cij).max(0.0).sqrt();
    let (kind, change) = constant
        .unwrap_or((if correlation > 0.0 { CombinationKind::Ratio } else { CombinationKind::Opposite }, 0.0));
    let sd = match kind {
        CombinationKind::Series => spread_of(b / (a + b), a / (a + b)),
        CombinationKind::Parallel => spread_of(a / (a + b), b / (a + b)),
        CombinationKind::Ratio | CombinationKind::Opposite => {
            // The combination of logarithms with the least variance.
            let sign = if correlation < 0.0 { 1.0 } else { -1.0 };
            let w = ((vj - sign * cij) / (vi + vj - 2.0 * sign * cij)).clamp(0.0, 1.0);
            spread_of(w, sign * (1.0 - w))
        }
    };
    let (p, q, unit) = (&parameters[i].id, &parameters[j].id, &parameters[i].unit);
    // Uncertainty by noise, plus the change of the combination along the valley.
    let percent = 196.0 * sd + 100.0 * change;
    let text = match kind {
        CombinationKind::Series => format!(
            "the data determine {p} and {q} only like springs in series: 1/(1/{p} + 1/{q}) = {:.4e} {unit} ± {percent:.1} %, not its parts",
            a * b / (a + b)
        ),
        CombinationKind::Parallel => {
            format!(
                "the data determine the sum {p} + {q} = {:.4e} {unit} ± {percent:.1} %, not its parts",
                a + b
            )
        }
        CombinationKind::Ratio => {
            format!(
                "{p} and {q} can rise together (correlation {correlation:.2}): the data determine their ratio better than either value"
            )
        }
        CombinationKind::Opposite => {
            format!(
                "{p} can rise while {q} falls (correlation {correlation:.2}): the data determine a combination better than either value"
            )
        }
    };
    Combination { parameters: (i, j), kind, correlation, sd, text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uncertainty::certainty;
    use machine::{FitRule, Mechanism, Role};
    use nalgebra::DMatrix;

    fn parameter(id: &str) -> Parameter {
        let range = (100.0, 1e5);
        Parameter {
            id: id.into(),
            unit: "N*m/rad".into(),
            mechanism: Mechanism::Stiffness,
            role: Role::Described,
            start: 1e3,
            lower: range.0,
            upper: range.1,
            scale: Scale::Logarithmic,
            fit: FitRule::Always,
            prior: None,
            source: String::new(),
            description: String::new(),
        }
    }

    /// Neither parameter is known.
    const OPEN: [bool; 2] = [false; 2];

    /// Returns the uncertainty after measuring one combination with the given logarithmic slopes.
    fn certainty_of(slopes: [f64; 2]) -> Certainty {
        let width = 1e3_f64.ln();
        let row = DMatrix::from_row_slice(1, 2, &[slopes[0] * width / 0.01, slopes[1] * width / 0.01]);
        certainty(&(row.transpose() * row), 1.0)
    }

    /// Returns a valley along which a sum, a harmonic sum or a ratio stays constant.
    fn valley_of(values: [f64; 2], keep: CombinationKind) -> impl Fn(usize, f64) -> Option<Vec<f64>> {
        move |column, by| {
            let moved = values[column] * (by * 1e3_f64.ln()).exp();
            let (sum, harmonic) = sums(values[0], values[1]);
            let other = match keep {
                CombinationKind::Series => 1.0 / (1.0 / harmonic - 1.0 / moved),
                CombinationKind::Parallel => sum - moved,
                _ => values[1 - column] * moved / values[column],
            };
            (other > 0.0).then(|| if column == 0 { vec![moved, other] } else { vec![other, moved] })
        }
    }

    #[test]
    fn springs_in_series_and_in_parallel_are_distinguished_even_where_equal() {
        let (a, b) = (parameter("k_m"), parameter("k_s"));
        for values in [[400.0, 800.0], [400.0, 400.0]] {
            let sum = values[0] + values[1];
            let shares = [values[0] / sum, values[1] / sum];
            let series = combinations(
                &[&a, &b],
                &values,
                (&certainty_of([shares[1], shares[0]]), &OPEN),
                valley_of(values, CombinationKind::Series),
            );
            assert!(series.len() == 1 && series[0].kind == CombinationKind::Series, "{series:?}");
            assert!((series[0].sd - 0.01).abs() < 2e-3, "{series:?}");
            let parallel = combinations(
                &[&a, &b],
                &values,
                (&certainty_of(shares), &OPEN),
                valley_of(values, CombinationKind::Parallel),
            );
            assert_eq!(parallel[0].kind, CombinationKind::Parallel, "{parallel:?}");
        }
        let ratio = combinations(
            &[&a, &b],
            &[400.0, 800.0],
            (&certainty_of([1.0, -1.0]), &OPEN),
            valley_of([400.0, 800.0], CombinationKind::Ratio),
        );
        assert_eq!(ratio[0].kind, CombinationKind::Ratio);
        // Without a valley neither sum is claimed.
        let open = combinations(&[&a, &b], &[400.0, 800.0], (&certainty_of([2.0, 1.0]), &OPEN), |_, _| None);
        assert_eq!(open[0].kind, CombinationKind::Opposite);
    }
}
