//! Which combinations of parameters the data determine where they do not determine each.

use super::uncertainty::Certainty;
use crate::machine::{Parameter, Scale};

/// How two parameters make up for each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
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
    /// Columns of the two, as in [`Certainty`].
    pub columns: (usize, usize),
    /// How they make up for each other.
    pub kind: Kind,
    /// Their correlation.
    pub correlation: f64,
    /// Relative standard deviation of the combination.
    pub sd: f64,
    /// All of it in words.
    pub text: String,
}

/// From this correlation two parameters are told of together.
const CORRELATED: f64 = 0.9;
/// Agreement of the weights with those of springs in series or side by side.
const WEIGHTS: f64 = 0.12;

/// The combinations among the parameters of the columns, the tightest first.
pub fn combinations(parameters: &[&Parameter], values: &[f64], certainty: &Certainty) -> Vec<Combination> {
    let mut found = Vec::new();
    for i in 0..parameters.len() {
        for j in 0..i {
            let correlation = certainty.correlation[i][j];
            let both_sure = certainty.identifiable[i] && certainty.identifiable[j];
            let logarithmic = [i, j].iter().all(|k| parameters[*k].scale == Scale::Logarithmic);
            if correlation.abs() >= CORRELATED && !both_sure && logarithmic {
                found.push(combination(parameters, values, certainty, (j, i)));
            }
        }
    }
    found.sort_by(|a, b| a.sd.total_cmp(&b.sd));
    found
}

fn combination(parameters: &[&Parameter], values: &[f64], certainty: &Certainty, (i, j): (usize, usize)) -> Combination {
    // Covariance of the logarithms.
    let width = |k: usize| (parameters[k].upper / parameters[k].lower).ln();
    let entry = |a: usize, b: usize| certainty.covariance[(a, b)] * width(a) * width(b);
    let (vi, vj, cij) = (entry(i, i), entry(j, j), entry(i, j));
    let correlation = certainty.correlation[i][j];
    // Weights (w, ±(1 − w)) of the combination of logarithms that scatters least.
    let sign = if correlation < 0.0 { 1.0 } else { -1.0 };
    let spread = vi + vj - 2.0 * sign * cij;
    let w = ((vj - sign * cij) / spread).clamp(0.0, 1.0);
    let sd = (w * w * vi + (1.0 - w) * (1.0 - w) * vj + 2.0 * sign * w * (1.0 - w) * cij).max(0.0).sqrt();
    let (a, b) = (values[i], values[j]);
    let same_unit = parameters[i].unit == parameters[j].unit;
    let kind = if correlation > 0.0 {
        Kind::Ratio
    } else if same_unit && (w - b / (a + b)).abs() < WEIGHTS {
        Kind::Series
    } else if same_unit && (w - a / (a + b)).abs() < WEIGHTS {
        Kind::Parallel
    } else {
        Kind::Opposite
    };
    let (p, q, unit) = (&parameters[i].id, &parameters[j].id, &parameters[i].unit);
    let percent = 196.0 * sd;
    let text = match kind {
        Kind::Series => format!(
            "the data see {p} and {q} like springs in series: 1/(1/{p} + 1/{q}) = {:.4e} {unit} ± {percent:.1} %, but not how it divides between them",
            a * b / (a + b)
        ),
        Kind::Parallel => {
            format!("the data see the sum {p} + {q} = {:.4e} {unit} ± {percent:.1} %, but not how it divides between them", a + b)
        }
        Kind::Ratio => format!("{p} and {q} can rise together (correlation {correlation:.2}): the data see their ratio better than each"),
        Kind::Opposite => {
            format!("{p} can rise while {q} falls (correlation {correlation:.2}): the data see a combination of both better than each")
        }
    };
    Combination { columns: (i, j), kind, correlation, sd, text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::uncertainty::certainty;
    use crate::machine::FitRule;
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
            sd: None,
            source: String::new(),
        }
    }

    /// The information of a measured combination with the given logarithmic slopes.
    fn seen(slopes: [f64; 2]) -> Certainty {
        let width = 1e3_f64.ln();
        let row = DMatrix::from_row_slice(1, 2, &[slopes[0] * width / 0.01, slopes[1] * width / 0.01]);
        certainty(&(row.transpose() * row), 1.0)
    }

    #[test]
    fn springs_in_series_and_dampers_side_by_side_are_told_apart() {
        let (a, b) = (parameter("k_m"), parameter("k_s"));
        let (ka, kb) = (400.0, 800.0);
        let sum = ka + kb;
        let series = combinations(&[&a, &b], &[ka, kb], &seen([kb / sum, ka / sum]));
        assert!(series.len() == 1 && series[0].kind == Kind::Series, "{series:?}");
        assert!((series[0].sd - 0.01).abs() < 2e-3, "{series:?}");
        let parallel = combinations(&[&a, &b], &[ka, kb], &seen([ka / sum, kb / sum]));
        assert_eq!(parallel[0].kind, Kind::Parallel);
        let ratio = combinations(&[&a, &b], &[ka, kb], &seen([1.0, -1.0]));
        assert_eq!(ratio[0].kind, Kind::Ratio);
    }
}
