//! How far the machine as described is off, and is off with what was found: fitted plainly, without what is ordinarily a little wrong, as anybody who writes
//! the effect into the description and identifies it again would find it.

use super::evidence::PartialGap;
use super::fit::{Fitted, Fitter, at_start, start_of};
use super::hypothesis::{Hypothesis, HypothesisKind, interfaces};
use identification::objective::ObjectiveError;
use machine::{Effect, Machine};
use measurement::HoldOutSet;
use optimizer::Control;

/// Steps of the fits, and the relative gain of χ² at which they end.
const STEPS: (u64, f64) = (200, 1e-6);

/// Plain machines, fitted to the data of a diagnosis. Modes carry no nuisances: there they are the ones diagnosed.
pub(super) struct NominalRefit<'p, 's> {
    fitter: Fitter<'s>,
    /// Whether plain machines are others than those diagnosed.
    others: bool,
    effects: &'p [Effect],
    /// Free shapes at interfaces of the machine as described.
    shapes: Vec<Hypothesis>,
    /// The machine as described and its fit.
    described: (Hypothesis, Fitted),
}

impl<'p, 's> NominalRefit<'p, 's> {
    /// Of a machine, with the fit that a diagnosis begins with.
    ///
    /// # Errors  as [`Fitter::objective`].
    pub fn new(
        machine: &Machine,
        effects: &'p [Effect],
        fitter: &Fitter<'s>,
        nominal: (&Hypothesis, &Fitted),
        control: &Control,
    ) -> Result<Self, ObjectiveError> {
        let (others, fitter) = (fitter.has_nuisances(), fitter.without_nuisances());
        let machine = if others { Hypothesis::nominal(machine.clone()) } else { nominal.0.clone() };
        let mut fitted = nominal.1.clone();
        if others {
            let objective = fitter.objective(&machine)?;
            let start = carried_over(&machine, nominal);
            // A second time from where it ends: fresh steps go on down a valley.
            fitted = fitter.descend_to(&objective, &start, STEPS, control);
            fitted = fitter.descend_to(&objective, &fitted, STEPS, control);
        }
        Ok(NominalRefit { fitter, others, effects, shapes: interfaces(&machine), described: (machine, fitted) })
    }

    /// The machine as described and its fit.
    pub fn described(&self) -> &(Hypothesis, Fitted) {
        &self.described
    }

    /// The plain machine with what a hypothesis adds; `None` for what it cannot have.
    fn like(&self, of: &Hypothesis) -> Option<Hypothesis> {
        match &of.kind {
            HypothesisKind::Nominal => Some(self.described.0.clone()),
            HypothesisKind::Interface { .. } => self.shapes.iter().find(|shape| shape.id == of.id).cloned(),
            HypothesisKind::Effect | HypothesisKind::Release => of.id.split('+').try_fold(self.described.0.clone(), |machine, id| {
                if let Some(parameter) = machine.machine.parameter(id) {
                    return Some(machine.releasing(parameter));
                }
                machine.with(Effect::put_in(self.effects, id, &of.machine)?).ok()
            }),
        }
    }

    /// What a hypothesis adds to the machine as described, and its fit: from the values that were found with nuisances, and from the fit of the machine as
    /// described with what is added as it was found and at nothing, so that it can only be better than without.
    ///
    /// # Errors  as [`Fitter::objective`].
    pub fn of(&self, found: (&Hypothesis, &Fitted), control: &Control) -> Result<Option<(Hypothesis, Fitted)>, ObjectiveError> {
        if !self.others {
            return Ok(Some((found.0.clone(), found.1.clone())));
        }
        if found.0.kind == HypothesisKind::Nominal {
            return Ok(Some(self.described.clone()));
        }
        let Some(like) = self.like(found.0) else { return Ok(None) };
        let near = carried_over(&like, found);
        let base = &self.described.1;
        let added: Vec<f64> = like.added.iter().map(|at| near.units[*at]).collect();
        let objective = self.fitter.objective(&like)?;
        let starts = [near, start_of(&like, base, &added), start_of(&like, base, &[])];
        let ends = starts.iter().map(|start| self.fitter.descend_to(&objective, start, STEPS, control));
        let best = ends.min_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        Ok(best.map(|best| (like.clone(), best)))
    }

    /// Gaps of data with a plain machine.
    ///
    /// # Errors  as [`Fitter::gaps`].
    pub fn gaps(&self, (hypothesis, fitted): &(Hypothesis, Fitted), data: &HoldOutSet<'_>) -> Result<Vec<PartialGap>, ObjectiveError> {
        self.fitter.gaps(hypothesis, fitted, data)
    }
}

/// The values of a fit in another machine, by the ids of its parameters; the start of those that it has beside them.
fn carried_over(machine: &Hypothesis, (hypothesis, fitted): (&Hypothesis, &Fitted)) -> Fitted {
    let mut start = at_start(machine);
    for (unit, parameter) in start.units.iter_mut().zip(&machine.machine.parameters) {
        if let Some(at) = hypothesis.machine.parameter(&parameter.id) {
            *unit = fitted.units[at];
        }
    }
    start
}
