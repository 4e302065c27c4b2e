//! Ranking of the fitted candidates: their statistics, and which of them the data cannot distinguish.

use super::evidence::PartialGap;
use super::null_distribution::NullDistribution;
use super::screening::{Candidate, Screening};
use super::thresholds::Thresholds;

/// Penalty on a candidate in the ranking by χ², in units of its null scale times its excess.
const PENALTY: f64 = 8.0;
/// Difference of χ² within which candidates are indistinguishable (error rate 7 %). The second adds a share
/// of the best reduction of χ² for the error of the model, for FRFs at most the misfit beyond null
/// simulations.
pub const EQUIVALENT: f64 = 9.0;
const MODEL_ERROR: f64 = 0.1;
/// Least reduction of χ² by a rival, as a share of that by the best candidate.
const RIVAL_REDUCTION: f64 = 0.5;
/// Shortfall in cross-validation that a rival may have, as a share of the best candidate's improvement over
/// the nominal machine.
pub(super) const SHORTFALL: f64 = 0.2;

/// A candidate effect with its figures.
#[derive(Debug, Clone, PartialEq)]
pub struct TriedEffect {
    /// The candidate.
    pub candidate: Candidate,
    /// Reduction of χ² over its scale in null simulations and over the excess that the candidate leaves.
    pub statistic: f64,
    /// Share of null simulations whose largest statistic over all candidates is at least as large.
    pub p_value: f64,
    /// Gaps of the held-out data, predicted by the machine as described with the candidate.
    pub held_out: Vec<PartialGap>,
}

/// A generic impedance at an interface with its figures.
#[derive(Debug, Clone, PartialEq)]
pub struct TriedLocation {
    /// The candidate.
    pub candidate: Candidate,
    /// Gaps of the held-out data, predicted with it.
    pub held_out: Vec<PartialGap>,
}

/// Computes the statistics of all fitted candidates, ordered by penalised χ².
pub(super) fn rank(screening: &Screening, null: &NullDistribution, count: f64) -> Vec<TriedEffect> {
    let mut tried: Vec<TriedEffect> = screening
        .candidates
        .iter()
        .filter(|c| c.fitted.is_some())
        .map(|candidate| {
            let statistic =
                candidate.gain / null.scale(&candidate.id) / null.excess(candidate.chi_square() / count);
            TriedEffect {
                candidate: candidate.clone(),
                statistic,
                p_value: null.p_value(statistic),
                held_out: Vec::new(),
            }
        })
        .collect();
    tried.sort_by(|a, b| penalised(a).total_cmp(&penalised(b)));
    // A fit that is hardly different from that of another effect comes first only if it is better by what the
    // data can tell.
    if let Some(best) = tried.first().filter(|best| best.candidate.is_limit) {
        let reach = penalised(best) + EQUIVALENT * null.excess(best.candidate.chi_square() / count);
        if let Some(at) = tried.iter().position(|t| !t.candidate.is_limit && penalised(t) <= reach) {
            tried[..=at].rotate_right(1);
        }
    }
    tried
}

/// Returns χ² plus a penalty in proportion to the candidate's null scale; infinite for a candidate that does
/// not reduce χ².
fn penalised(tried: &TriedEffect) -> f64 {
    let TriedEffect { candidate, statistic, .. } = tried;
    if candidate.gain == 0.0 {
        f64::INFINITY
    } else {
        candidate.chi_square() + PENALTY * candidate.gain / statistic
    }
}

/// Returns the indices of the candidates indistinguishable from the best; one with more parameters only where
/// each of these reduces χ² by more than the difference within which candidates are indistinguishable. A fit
/// that is hardly different from that of another effect counts one parameter more.
pub(super) fn indistinguishable(
    tried: &[TriedEffect],
    null: &NullDistribution,
    count: f64,
    limits: Thresholds,
) -> Vec<usize> {
    let Some(best) = tried.first() else { return Vec::new() };
    let unit = null.excess(best.candidate.chi_square() / count);
    let reach = penalised(best)
        + EQUIVALENT * unit
        + limits.margin(MODEL_ERROR * best.candidate.gain, best.candidate.chi_square(), unit);
    let added =
        |t: &TriedEffect| t.candidate.fitted.as_ref().map_or(0, |(hypothesis, _)| hypothesis.added.len());
    let counted = |t: &TriedEffect| added(t) + usize::from(t.candidate.is_limit);
    let price = |t: &TriedEffect| EQUIVALENT * unit * counted(t).saturating_sub(counted(best)) as f64;
    let as_simple = |t: &TriedEffect| {
        price(t) == 0.0 || t.candidate.chi_square() + price(t) < best.candidate.chi_square()
    };
    let explains = |t: &TriedEffect| t.candidate.gain >= RIVAL_REDUCTION * best.candidate.gain;
    let rival = |t: &TriedEffect| penalised(t) <= reach && explains(t) && as_simple(t);
    (0..tried.len()).filter(|at| rival(&tried[*at])).collect()
}

/// Moves equally well fitting candidates that predict left-out positions much worse behind the others and
/// returns their range. The best stays if it fits clearly better than the best predictor.
pub(super) fn keep_predictive(
    tried: &mut [TriedEffect],
    same: &mut Vec<usize>,
    nominal: f64,
    null: &NullDistribution,
    count: f64,
) -> std::ops::Range<usize> {
    let loss = |t: &TriedEffect| t.candidate.left_out.unwrap_or(f64::INFINITY);
    let Some(best_predictor) = same.iter().map(|at| &tried[*at]).min_by(|a, b| loss(a).total_cmp(&loss(b)))
    else {
        return 0..0;
    };
    let reach = loss(best_predictor) + SHORTFALL * (nominal - loss(best_predictor)).max(0.0) + EQUIVALENT;
    let margin = EQUIVALENT * null.excess(tried[0].candidate.chi_square() / count);
    let fits = tried[0].candidate.chi_square() + margin < best_predictor.candidate.chi_square();
    let stays = |at: usize| tried[at].candidate.left_out.is_none_or(|l| l <= reach) || (at == 0 && fits);
    let (kept, dropped): (Vec<usize>, Vec<usize>) = same.iter().partition(|at| stays(**at));
    let (count, all) = (kept.len(), same.len());
    let others = (0..tried.len()).filter(|at| !same.contains(at));
    let ordered: Vec<TriedEffect> =
        kept.into_iter().chain(dropped).chain(others).map(|at| tried[at].clone()).collect();
    tried.clone_from_slice(&ordered);
    *same = (0..count).collect();
    count..all
}
