//! Whether the records of several positions are those of one position.

use rayon::prelude::*;

use super::data_fault::Fault;
use super::evidence::Domain;
use super::facts::OnePosition;
use super::fit::Fitter;
use super::hypothesis::Hypothesis;
use super::record_checks::factors_of_alike;
use super::screening::nominal_fits;
use identification::objective::ObjectiveError;
use long_work::Control;
use measurement::HoldOutSet;
use numeric::parallel::OrFirstError;

/// Returns the position at which all records fit best, where they agree with each other within their noise but
/// for a factor, with χ² there and at their own positions, with the same factors.
///
/// # Errors  as [`Fitter::objective`].
pub(super) fn one_position(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    nominal: &Hypothesis,
    seed: u64,
    control: &Control,
) -> Result<Option<OnePosition>, ObjectiveError> {
    let Domain::Frf(_) = fitter.domain else { return Ok(None) };
    let set = fitter.fit.set();
    let all: Vec<usize> = fitter.fit.frfs().iter().chain(held_out.frfs()).copied().collect();
    let Some(factors) = factors_of_alike(set, &all) else { return Ok(None) };
    let mut positions: Vec<usize> = all.iter().filter_map(|frf| set.frfs[*frf].position).collect();
    positions.sort_unstable();
    positions.dedup();
    // The same records with their factors removed, at their own positions or all at one.
    let fit_at = |position: &Option<usize>| -> Result<(f64, Option<usize>), ObjectiveError> {
        let mut other = set.clone();
        for (frf, factor) in &factors {
            let frf = &mut other.frfs[*frf];
            frf.position = frf.position.map(|own| position.unwrap_or(own));
            frf.lines.iter_mut().for_each(|line| line.value /= *factor);
        }
        let there = fitter.on(fitter.fit.in_version(&other));
        let part = control.within(&format!("one position {position:?}"));
        Ok((nominal_fits(&there, nominal, seed, &part)?[0].chi_square, *position))
    };
    let places: Vec<Option<usize>> = std::iter::once(None).chain(positions.into_iter().map(Some)).collect();
    let mut fits: Vec<(f64, Option<usize>)> = places.par_iter().map(fit_at).or_first_error()?;
    if control.stopped() {
        return Ok(None);
    }
    let chi_square_at_own = fits.remove(0).0;
    let best = fits.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(best.and_then(|(chi_square, at)| {
        let fault = Fault::OnePosition(at?).facts(set);
        Some(OnePosition { fault, chi_square, chi_square_at_own })
    }))
}
