//! Shares of cases with their exact intervals.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use numeric::distribution::clopper_pearson;

use super::judge::Judgement;

/// A count of cases with the exact 95 % interval of its share.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Proportion {
    /// Cases counted.
    pub count: usize,
    /// Number of cases in total.
    pub of: usize,
    /// Share; absent without cases.
    pub share: Option<f64>,
    /// Clopper–Pearson interval; absent without cases.
    pub interval95: Option<[f64; 2]>,
}

impl Proportion {
    /// Computes the share of `count` among `of` cases.
    pub fn new(count: usize, of: usize) -> Self {
        Self {
            count,
            of,
            share: (of > 0).then(|| count as f64 / of as f64),
            interval95: clopper_pearson(count, of, 0.95),
        }
    }
}

/// Computes the share of counted judgements.
pub fn share<'a>(
    of: impl IntoIterator<Item = &'a Judgement>,
    counted: impl Fn(&Judgement) -> bool,
) -> Proportion {
    let (count, all) =
        of.into_iter().fold((0, 0), |(c, n), judged| (c + usize::from(counted(judged)), n + 1));
    Proportion::new(count, all)
}
