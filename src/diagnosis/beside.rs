//! What is missing beside the chosen effects: a further effect, or one that describes one of them in more
//! detail.

use super::fit::{Fitted, Fitter, IMPROVEMENT};
use super::hypothesis::Hypothesis;
use super::screening::{Screening, hypotheses, implausibility};
use super::search::{Effort, search};
use identification::objective::ObjectiveError;
use long_work::Control;
use machine::{Effect, Machine};

/// Fits what may be missing beside the chosen effects. The search may also find a deeper minimum of the
/// chosen machine, which then was found once.
pub(super) fn beside(
    fitter: &Fitter<'_>,
    machine: &Machine,
    effects: &[Effect],
    chosen: (&Hypothesis, &Fitted),
    seed: u64,
    control: &Control,
) -> Result<Screening, ObjectiveError> {
    let others: Vec<Effect> = effects.iter().filter(|e| !chosen.0.effects.contains(&e.id)).cloned().collect();
    let (apply, _) = hypotheses(fitter, machine, chosen.0, &others, &[]);
    // Only the best candidate counts: how often a search found it is not asked.
    let effort = Effort { located: (0, 0), searches: 1, seed };
    let mut found =
        search(fitter, chosen.0.clone(), vec![chosen.1.clone()], (apply, Vec::new()), effort, control)?.0;
    let is_deeper = found.base.chi_square < chosen.1.chi_square - IMPROVEMENT;
    found.base = match is_deeper && implausibility(chosen.0, &found.base).is_none() {
        true => Fitted { found: 1, ..found.base },
        false => chosen.1.clone(),
    };
    for candidate in &mut found.candidates {
        candidate.gain = (found.base.chi_square - candidate.chi_square()).max(0.0);
    }
    Ok(found)
}
