//! Which combinations of parameters the data determine where they do not determine each.

use rayon::prelude::*;

use super::uncertainty::Certainty;
use machine::{Parameter, Scale};

/// How two parameters make up for each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CombinationKind {
    /// Like springs in series: 1/a + 1/b is determined.
    Series,
    /// Like springs or dampers side by side: a + b is determined.
    Parallel,
    /// One rises as the other falls.
    Opposite,
    /// Both rise together: their ratio is determined.
    Ratio,
}

/// Two parameters of which the data determine a combination better than each.
#[derive(Debug, Clone, PartialEq)]
pub struct Combination {
    /// The two, by index.
    pub parameters: (usize, usize),
    /// How they make up for each other.
    pub kind: CombinationKind,
    /// Their correlation.
    pub correlation: f64,
    /// Relative standard deviation of the combination.
    pub sd: f64,
    /// All of it in words.
    pub text: String,
}

/// From this correlation two parameters are told of together.
const CORRELATED: f64 = 0.9;
/// Relative standard deviation from which a combination is not told.
const WORTH_TELLING: f64 = 0.25;
/// Moves along a valley that are tried, the farthest first, in the unit interval of a parameter.
const MOVES: [f64; 3] = [0.5, 0.25, 0.1];

/// The combinations among the parameters of the columns, the tightest first. `valley(column, by)` gives the values of all columns after that one
/// was moved by so much of its unit interval and the others have followed; `None` where χ² rises too much for that.
pub fn combinations(
    parameters: &[&Parameter],
    values: &[f64],
    certainty: &Certainty,
    valley: impl Fn(usize, f64) -> Option<Vec<f64>> + Sync,
) -> Vec<Combination> {
    let worth = |&(j, i): &(usize, usize)| {
        let both_sure = certainty.identifiable[i] && certainty.identifiable[j];
        !both_sure && [i, j].iter().all(|k| parameters[*k].scale == Scale::Logarithmic)
    };
    let pairs: Vec<(usize, usize)> = (0..parameters.len()).flat_map(|i| (0..i).map(move |j| (j, i))).filter(worth).collect();
    let of_pair = |&(j, i): &(usize, usize)| {
        // Far from a straight valley, as where one of two springs in series is all but rigid, correlations say nothing.
        let kind = (parameters[i].unit == parameters[j].unit).then(|| kept((j, i), values, certainty, &valley)).flatten();
        let told = kind.is_some() || certainty.correlation[i][j].abs() >= CORRELATED;
        told.then(|| combination(parameters, values, certainty, (j, i), kind))
    };
    let mut found: Vec<Combination> = pairs.par_iter().filter_map(of_pair).collect();
    // A combination that is hardly known itself is not worth a sentence.
    found.retain(|c| c.sd < WORTH_TELLING);
    found.sort_by(|a, b| a.sd.total_cmp(&b.sd));
    found
}

/// Sum and harmonic sum (springs in series) of two values.
fn sums(a: f64, b: f64) -> (f64, f64) {
    (a + b, a * b / (a + b))
}

/// Which of sum and harmonic sum stays while one of the two values is moved along the valley and the other follows, and by how much it changes
/// all the same (relative): by a fifth at most of what the values do themselves, and by a quarter at most of what the other sum does. To first
/// order both sums are the same for equal values, so that only a finite move tells.
fn kept(
    (i, j): (usize, usize),
    values: &[f64],
    certainty: &Certainty,
    valley: &(impl Fn(usize, f64) -> Option<Vec<f64>> + Sync),
) -> Option<(CombinationKind, f64)> {
    let here = sums(values[i], values[j]);
    let (mut moved, mut sum, mut harmonic) = (0.0_f64, 0.0_f64, 0.0_f64);
    // The one that is known less is moved, the other follows.
    let column = if certainty.sd[i] >= certainty.sd[j] { i } else { j };
    let farthest = |sign: f64| MOVES.into_iter().find_map(|by| valley(column, sign * by));
    let (up, down) = rayon::join(|| farthest(1.0), || farthest(-1.0));
    for there in [up, down].into_iter().flatten() {
        let now = sums(there[i], there[j]);
        moved = moved.max((there[i] / values[i]).ln().abs().min((there[j] / values[j]).ln().abs()));
        sum = sum.max((now.0 / here.0).ln().abs());
        harmonic = harmonic.max((now.1 / here.1).ln().abs());
    }
    let stays = |own: f64, other: f64| moved > 0.02 && own < 0.2 * moved && own < 0.25 * other;
    if stays(harmonic, sum) {
        Some((CombinationKind::Series, harmonic))
    } else {
        stays(sum, harmonic).then_some((CombinationKind::Parallel, sum))
    }
}

fn combination(
    parameters: &[&Parameter],
    values: &[f64],
    certainty: &Certainty,
    (i, j): (usize, usize),
    kept: Option<(CombinationKind, f64)>,
) -> Combination {
    // Covariance of the logarithms.
    let width = |k: usize| (parameters[k].upper / parameters[k].lower).ln();
    let entry = |a: usize, b: usize| certainty.covariance[(a, b)] * width(a) * width(b);
    let (vi, vj, cij) = (entry(i, i), entry(j, j), entry(i, j));
    let correlation = certainty.correlation[i][j];
    let (a, b) = (values[i], values[j]);
    // Relative standard deviation of wᵢ·ln a + wⱼ·ln b.
    let spread_of = |wi: f64, wj: f64| (wi * wi * vi + wj * wj * vj + 2.0 * wi * wj * cij).max(0.0).sqrt();
    let (kind, change) = kept.unwrap_or((if correlation > 0.0 { CombinationKind::Ratio } else { CombinationKind::Opposite }, 0.0));
    let sd = match kind {
        CombinationKind::Series => spread_of(b / (a + b), a / (a + b)),
        CombinationKind::Parallel => spread_of(a / (a + b), b / (a + b)),
        CombinationKind::Ratio | CombinationKind::Opposite => {
            // The combination of logarithms that scatters least.
            let sign = if correlation < 0.0 { 1.0 } else { -1.0 };
            let w = ((vj - sign * cij) / (vi + vj - 2.0 * sign * cij)).clamp(0.0, 1.0);
            spread_of(w, sign * (1.0 - w))
        }
    };
    let (p, q, unit) = (&parameters[i].id, &parameters[j].id, &parameters[i].unit);
    // What the noise leaves open, and what the valley shows that the sum is not quite what the data see.
    let percent = 196.0 * sd + 100.0 * change;
    let text = match kind {
        CombinationKind::Series => format!(
            "the data see {p} and {q} like springs in series: 1/(1/{p} + 1/{q}) = {:.4e} {unit} ± {percent:.1} %, but not how it divides between them",
            a * b / (a + b)
        ),
        CombinationKind::Parallel => {
            format!("the data see the sum {p} + {q} = {:.4e} {unit} ± {percent:.1} %, but not how it divides between them", a + b)
        }
        CombinationKind::Ratio => {
            format!("{p} and {q} can rise together (correlation {correlation:.2}): the data see their ratio better than each")
        }
        CombinationKind::Opposite => {
            format!("{p} can rise while {q} falls (correlation {correlation:.2}): the data see a combination of both better than each")
        }
    };
    Combination { parameters: (i, j), kind, correlation, sd, text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uncertainty::certainty;
    use machine::FitRule;
    use nalgebra::DMatrix;

    fn parameter(id: &str) -> Parameter {
        let range = (100.0, 1e5);
        Parameter {
            id: id.into(),
            unit: "N*m/rad".into(),
            start: 1e3,
            lower: range.0,
            upper: range.1,
            scale: Scale::Logarithmic,
            fit: FitRule::Always,
            prior: None,
            source: String::new(),
        }
    }

    /// The information of a measured combination with the given logarithmic slopes.
    fn seen(slopes: [f64; 2]) -> Certainty {
        let width = 1e3_f64.ln();
        let row = DMatrix::from_row_slice(1, 2, &[slopes[0] * width / 0.01, slopes[1] * width / 0.01]);
        certainty(&(row.transpose() * row), 1.0, &[])
    }

    /// Moves the first value by a share of its range and lets the second keep a sum or a harmonic sum.
    fn following(values: [f64; 2], keep: CombinationKind) -> impl Fn(usize, f64) -> Option<Vec<f64>> {
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
            let series = combinations(&[&a, &b], &values, &seen([shares[1], shares[0]]), following(values, CombinationKind::Series));
            assert!(series.len() == 1 && series[0].kind == CombinationKind::Series, "{series:?}");
            assert!((series[0].sd - 0.01).abs() < 2e-3, "{series:?}");
            let parallel = combinations(&[&a, &b], &values, &seen(shares), following(values, CombinationKind::Parallel));
            assert_eq!(parallel[0].kind, CombinationKind::Parallel, "{parallel:?}");
        }
        let ratio = combinations(&[&a, &b], &[400.0, 800.0], &seen([1.0, -1.0]), following([400.0, 800.0], CombinationKind::Ratio));
        assert_eq!(ratio[0].kind, CombinationKind::Ratio);
        // What cannot be followed is not claimed.
        let open = combinations(&[&a, &b], &[400.0, 800.0], &seen([2.0, 1.0]), |_, _| None);
        assert_eq!(open[0].kind, CombinationKind::Opposite);
    }
}
