//! Whether the records of several positions are those of one position.

use rayon::prelude::*;

use super::data_fault::{AGREES, Fault, RESTORED};
use super::fit::{Fitted, Fitter};
use super::hypothesis::Hypothesis;
use super::null_distribution::NullDistribution;
use super::ranking::EQUIVALENT;
use super::record_checks::factors_of_alike;
use super::screening::nominal_fits;
use identification::objective::ObjectiveError;
use measurement::HoldOutSet;
use numeric::parallel::OrFirstError;
use optimizer::Control;

/// Returns the fault that all records were measured at one position: they agree with each other within their noise but for a factor, and at one of the
/// positions with the nominal machine, as well as with any effect. `rival`: χ² and number of parameters of the best significant effect.
///
/// # Errors  as [`Fitter::objective`].
pub(super) fn one_position(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    (nominal, base): (&Hypothesis, &Fitted),
    rival: Option<(f64, usize)>,
    (null, seed): (&NullDistribution, u64),
    control: &Control,
) -> Result<Option<Fault>, ObjectiveError> {
    let set = fitter.fit.set();
    let all: Vec<usize> = fitter.fit.frfs().iter().chain(held_out.frfs()).copied().collect();
    let Some(factors) = factors_of_alike(set, &all) else { return Ok(None) };
    let mut positions: Vec<usize> = all.iter().filter_map(|frf| set.frfs[*frf].position).collect();
    positions.sort_unstable();
    positions.dedup();
    let at_one = |position: &usize| -> Result<(f64, usize), ObjectiveError> {
        let mut other = set.clone();
        for (frf, factor) in &factors {
            let frf = &mut other.frfs[*frf];
            frf.position = frf.position.and(Some(*position));
            frf.lines.iter_mut().for_each(|line| line.value /= *factor);
        }
        let there = fitter.on(fitter.fit.in_version(&other));
        let part = control.within(&format!("one position {position}"));
        Ok((nominal_fits(&there, nominal, seed, &part)?[0].chi_square, *position))
    };
    let fits: Vec<(f64, usize)> = positions.par_iter().map(at_one).or_first_error()?;
    let count = fitter.objective(nominal)?.observations() as f64;
    let reach = AGREES + RESTORED.1 * null.excess(base.chi_square / count);
    let explains = |chi_square: f64| rival.is_none_or(|(rival, _)| chi_square <= rival + EQUIVALENT * null.excess(rival / count));
    let best = fits.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(best
        .filter(|(chi_square, _)| null.excess(chi_square / count) <= reach && explains(*chi_square))
        .map(|(_, at)| Fault::OnePosition(at)))
}
