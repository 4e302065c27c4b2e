//! Refits without nuisance parameters: the gap of the machine as described, before and after an effect is
//! written into its description. A user who identifies the extended description obtains the same figures.

use super::evidence::PartialGap;
use super::fit::{Fitted, Fitter, at_start, start_of};
use super::hypothesis::{Hypothesis, HypothesisKind, interfaces};
use identification::objective::ObjectiveError;
use long_work::Control;
use machine::{Effect, Machine};
use measurement::HoldOutSet;

/// Steps of the fits, and the relative decrease of χ² at which they end.
const STEPS: (u64, f64) = (200, 1e-6);

/// Machines without nuisance parameters, fitted to the data of a diagnosis. Modes have no nuisance
/// parameters: their fits are those of the diagnosis.
pub(super) struct NominalRefit<'p, 's> {
    fitter: Fitter<'s>,
    /// Whether these machines differ from the diagnosed ones.
    refits: bool,
    effects: &'p [Effect],
    /// Generic impedances at interfaces of the machine as described.
    shapes: Vec<Hypothesis>,
    /// The machine as described and its fit.
    described: (Hypothesis, Fitted),
}

impl<'p, 's> NominalRefit<'p, 's> {
    /// Fits the machine as described, starting from the nominal fit of the diagnosis.
    ///
    /// # Errors  as [`Fitter::objective`].
    pub fn new(
        machine: &Machine,
        effects: &'p [Effect],
        fitter: &Fitter<'s>,
        nominal: (&Hypothesis, &Fitted),
        control: &Control,
    ) -> Result<Self, ObjectiveError> {
        let (refits, fitter) = (fitter.has_nuisances(), fitter.without_nuisances());
        let machine = if refits { Hypothesis::nominal(machine.clone()) } else { nominal.0.clone() };
        let mut fitted = nominal.1.clone();
        if refits {
            let objective = fitter.objective(&machine)?;
            let start = transferred(&machine, nominal);
            // Restart at the end: fresh steps continue along a valley.
            fitted = fitter.descend_until(&objective, &start, STEPS, control);
            fitted = fitter.descend_until(&objective, &fitted, STEPS, control);
        }
        Ok(NominalRefit {
            fitter,
            refits,
            effects,
            shapes: interfaces(&machine),
            described: (machine, fitted),
        })
    }

    /// Returns the machine as described and its fit.
    pub fn described(&self) -> &(Hypothesis, Fitted) {
        &self.described
    }

    /// Returns the machine as described with the addition of a hypothesis; `None` where the addition does not
    /// apply.
    fn counterpart(&self, of: &Hypothesis) -> Option<Hypothesis> {
        match &of.kind {
            HypothesisKind::Nominal => Some(self.described.0.clone()),
            HypothesisKind::Interface { .. } => {
                self.shapes.iter().find(|shape| shape.kind == of.kind).cloned()
            }
            HypothesisKind::Effect | HypothesisKind::Release => {
                of.effects.iter().try_fold(self.described.0.clone(), |machine, id| {
                    match Effect::contained_variant(self.effects, id, &of.machine) {
                        Some(effect) => machine.with(effect).ok(),
                        None => Some(machine.releasing(machine.machine.parameter(id)?)),
                    }
                })
            }
        }
    }

    /// Adds a hypothesis to the machine as described and fits it. Starts are the estimates with nuisance
    /// parameters, and the fit of the machine as described with the addition as estimated and at zero: χ²
    /// cannot exceed that without the addition.
    ///
    /// # Errors  as [`Fitter::objective`].
    pub fn of(
        &self,
        found: (&Hypothesis, &Fitted),
        control: &Control,
    ) -> Result<Option<(Hypothesis, Fitted)>, ObjectiveError> {
        if !self.refits {
            return Ok(Some((found.0.clone(), found.1.clone())));
        }
        if found.0.kind == HypothesisKind::Nominal {
            return Ok(Some(self.described.clone()));
        }
        let Some(counterpart) = self.counterpart(found.0) else { return Ok(None) };
        let near = transferred(&counterpart, found);
        let base = &self.described.1;
        let added: Vec<f64> = counterpart.added.iter().map(|at| near.units[*at]).collect();
        let objective = self.fitter.objective(&counterpart)?;
        let starts = [near, start_of(&counterpart, base, &added), start_of(&counterpart, base, &[])];
        let ends = starts.iter().map(|start| self.fitter.descend_until(&objective, start, STEPS, control));
        let best = ends.min_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        Ok(best.map(|best| (counterpart.clone(), best)))
    }

    /// Returns the gaps of data with such a machine.
    ///
    /// # Errors  as [`Fitter::gaps`].
    pub fn gaps(
        &self,
        (hypothesis, fitted): &(Hypothesis, Fitted),
        data: &HoldOutSet<'_>,
    ) -> Result<Vec<PartialGap>, ObjectiveError> {
        self.fitter.gaps(hypothesis, fitted, data)
    }
}

/// Transfers the values of a fit to another machine by the ids of its parameters; other parameters keep their
/// start.
pub(super) fn transferred(machine: &Hypothesis, (hypothesis, fitted): (&Hypothesis, &Fitted)) -> Fitted {
    let mut start = at_start(machine);
    for (unit, parameter) in start.units.iter_mut().zip(&machine.machine.parameters) {
        if let Some(at) = hypothesis.machine.parameter(&parameter.id) {
            *unit = fitted.units[at];
        }
    }
    start
}
