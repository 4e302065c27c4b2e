//! How far the machine as described is off, and is off with what was found: fitted plainly, without what is ordinarily a little wrong, as anybody who writes
//! the effect into the description and identifies it again would find it.

use super::domain::Part;
use super::fit::{Fitted, Fitter, at_start};
use super::hypothesis::{Hypothesis, Kind, interfaces};
use crate::machine::{Effect, Machine};
use crate::measurement::HoldOutSet;
use crate::objective::ObjectiveError;
use crate::optimizer::Control;

/// Steps of the fits, and the relative gain of χ² at which they end.
const STEPS: (u64, f64) = (200, 1e-6);

/// Plain machines, fitted to the data of a diagnosis. Modes carry no nuisances: there they are the ones diagnosed.
pub(super) struct Plain<'p, 's> {
    fitter: Fitter<'s>,
    effects: &'p [Effect],
    /// The machine as described.
    machine: Hypothesis,
    /// Free shapes at its interfaces.
    shapes: Vec<Hypothesis>,
    /// Its fit.
    base: Option<Fitted>,
}

impl<'p, 's> Plain<'p, 's> {
    /// Of a machine, with the fit that a diagnosis begins with.
    pub fn new(
        machine: &Machine,
        effects: &'p [Effect],
        fitter: &Fitter<'s>,
        nominal: (&Hypothesis, &Fitted),
        control: &Control,
    ) -> Result<Self, ObjectiveError> {
        let machine = Hypothesis::nominal(machine.clone());
        let shapes = interfaces(&machine);
        let mut plain = Plain { fitter: fitter.clone(), effects, machine, shapes, base: None };
        plain.base = plain.of(nominal, control)?.map(|(_, fitted)| fitted);
        // From where it ends without effects, too, which may be lower down the valley than the first.
        plain.base = plain.of(nominal, control)?.map(|(_, fitted)| fitted);
        Ok(plain)
    }

    /// The plain machine with what a hypothesis adds; `None` for what it cannot have.
    fn like(&self, of: &Hypothesis) -> Option<Hypothesis> {
        match &of.kind {
            Kind::Nominal => Some(self.machine.clone()),
            Kind::Interface { .. } => self.shapes.iter().find(|shape| shape.id == of.id).cloned(),
            Kind::Effect | Kind::Release => of.id.split('+').try_fold(self.machine.clone(), |machine, id| {
                if let Some(parameter) = machine.machine.parameters.iter().position(|p| p.id == id) {
                    return Some(machine.releasing(parameter));
                }
                // Of effects with one id, for machines described in different words, the one that was put in.
                let is_in = |e: &&Effect| e.patch.parameters.iter().all(|p| of.machine.parameters.iter().any(|own| own.id == p.id));
                machine.with(self.effects.iter().filter(|e| e.id == id).find(is_in)?).ok()
            }),
        }
    }

    /// A hypothesis and its fit without nuisances: from the values that were found with them, and from the fit of the machine as described.
    ///
    /// # Errors  as [`Fitter::objective`].
    pub fn of(
        &self,
        (hypothesis, fitted): (&Hypothesis, &Fitted),
        control: &Control,
    ) -> Result<Option<(Hypothesis, Fitted)>, ObjectiveError> {
        if !self.fitter.has_nuisances() {
            return Ok(Some((hypothesis.clone(), fitted.clone())));
        }
        let Some(like) = self.like(hypothesis) else { return Ok(None) };
        let found = |id: &str| hypothesis.machine.parameters.iter().position(|p| p.id == id).map(|at| fitted.units[at]);
        let parameters = &like.machine.parameters;
        let units: Vec<f64> = parameters.iter().map(|p| found(&p.id).unwrap_or_else(|| p.to_unit(p.start))).collect();
        let near = Fitted { units, tail: Vec::new(), chi_square: f64::INFINITY, agrees: true };
        let own = self.machine.machine.parameters.len();
        let from_base = |added: &Fitted| {
            let base = self.base.as_ref()?;
            let units = base.units.iter().take(own).chain(added.units.iter().skip(own)).copied().collect();
            Some(Fitted { units, ..near.clone() })
        };
        // With what is added as it was found, and at nothing: with it the fit can only be better than without.
        let (beside, nothing) = (from_base(&near), from_base(&at_start(&like)));
        let fitter = self.fitter.plainly();
        let objective = fitter.objective(&like)?;
        let ends = [Some(near), beside, nothing].into_iter().flatten().map(|start| fitter.descend_to(&objective, &start, STEPS, control));
        let best = ends.min_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        Ok(best.map(|best| (like.clone(), best)))
    }

    /// Gaps of data with a plain machine; none where there is no such machine.
    ///
    /// # Errors  as [`Fitter::gaps`].
    pub fn gaps(&self, of: Option<&(Hypothesis, Fitted)>, data: &HoldOutSet<'_>) -> Result<Vec<Part>, ObjectiveError> {
        of.map_or(Ok(Vec::new()), |(hypothesis, fitted)| self.fitter.plainly().gaps(hypothesis, fitted, data))
    }
}
