//! Records that contradict the others: a faulty channel is no effect.

use rayon::prelude::*;

use super::domain::{Domain, Part};
use super::fit::Fitter;
use super::null::Null;
use super::run::Survey;
use crate::measurement::FitSet;
use crate::objective::ObjectiveError;
use crate::optimizer::Control;

/// A record without which the others agree, while it alone contradicts them.
pub(super) fn faulty_record(fitter: &Fitter<'_>, survey: &Survey, null: &Null, control: &Control) -> Result<Option<usize>, ObjectiveError> {
    let Domain::Frf(_) = fitter.domain else { return Ok(None) };
    let frfs = &fitter.fit.frfs;
    if frfs.len() < 3 {
        return Ok(None);
    }
    let without: Result<Vec<(usize, f64, f64)>, ObjectiveError> = frfs
        .par_iter()
        .map(|left| {
            let kept = fitter.on(FitSet { frfs: frfs.iter().copied().filter(|f| f != left).collect(), ..fitter.fit.clone() });
            let objective = kept.objective(&survey.nominal)?;
            let part = kept.descend(&objective, &survey.base, 25, control);
            let own = fitter.on(FitSet { frfs: vec![*left], ..fitter.fit.clone() });
            let count = own.objective(&survey.nominal)?.observations() as f64;
            Ok((*left, part.chi_square / objective.observations() as f64, own.loss(&survey.nominal, &part)? / count))
        })
        .collect();
    let mut without = without?;
    without.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (worst, rest, own) = without[0];
    let agrees = null.excess(rest) <= 1.6;
    let second = without[1].1;
    Ok((agrees && own > 10.0 * rest && second > 2.5 * rest).then_some(worst))
}

/// A held-out record that is far off where all others of its channel and position are not.
pub(super) fn contradicting(held_out: &[Part]) -> Option<usize> {
    let mut gaps: Vec<(f64, Option<usize>)> = held_out.iter().map(|p| (p.gap, p.frf)).collect();
    gaps.sort_by(|a, b| b.0.total_cmp(&a.0));
    let [(worst, frf), (second, _), ..] = gaps[..] else { return None };
    frf.filter(|_| worst > 0.2 && worst > 8.0 * second)
}
