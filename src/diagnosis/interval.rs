//! How large what is missing is: intervals of the parameters that a chosen model adds.

use super::evidence::DomainObjective;
use super::facts::Facts;
use super::fit::{Fitted, Fitter, coordinates_of};
use super::hypothesis::Hypothesis;
use super::judgement::Judgement;
use identification::objective::ObjectiveError;
use identification::{CHI_SQUARE_95, ProfileStart, Profiler, Profiles, certainty};
use long_work::Control;
use optimizer::Polished;

/// An interval by parameter id.
pub(super) type Interval = (String, (f64, f64));

/// Returns the 95 % interval of each parameter that the chosen model adds, by profile likelihood with all
/// others and the tolerances re-optimised. χ² rises by its 95 % quantile times the misfit over null
/// simulations. Empty for modes, and where the verdict names nothing.
///
/// # Errors  as [`Fitter::objective`].
pub(super) fn intervals(
    fitter: &Fitter<'_>,
    (hypothesis, fitted): (&Hypothesis, &Fitted),
    (judgement, facts): (&Judgement, &Facts),
    control: &Control,
) -> Result<Vec<Interval>, ObjectiveError> {
    let objective = fitter.objective(hypothesis)?;
    let DomainObjective::Frf(squares) = &objective else { return Ok(Vec::new()) };
    let added: Vec<(usize, usize)> = hypothesis
        .added
        .iter()
        .filter_map(|index| Some((*index, objective.free().iter().position(|free| free == index)?)))
        .collect();
    if added.is_empty() || !judgement.verdict.kind.explains() {
        return Ok(Vec::new());
    }
    let place = coordinates_of(&objective, fitted).0;
    let excess = facts.excess(fitted.chi_square);
    let normal = objective.squares(|squares| squares.normal(&place));
    let certainty = certainty(&normal.information, excess);
    let minimum = Polished { place, normal, evaluations: 0, converged: true };
    let minima = [ProfileStart { minimum, certainty }];
    let profiler = Profiler { squares, minima: &minima, rise: CHI_SQUARE_95 * excess, control };
    let coordinates: Vec<usize> = added.iter().map(|(_, coordinate)| *coordinate).collect();
    let Profiles::Regions(regions) = profiler.regions(&coordinates) else { return Ok(Vec::new()) };
    let of = |((index, _), region): (&(usize, usize), Vec<(f64, f64)>)| {
        let parameter = &hypothesis.machine.parameters[*index];
        let (low, high) = (region.first()?.0, region.last()?.1);
        Some((parameter.id.clone(), (parameter.from_unit(low), parameter.from_unit(high))))
    };
    Ok(added.iter().zip(regions).filter_map(of).collect())
}
