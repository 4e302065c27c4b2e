//! Probability that a choice of measurements settles an ambiguous verdict.

use super::{ChannelNames, PlanRequest};
use crate::identified::check_current;
use crate::{Settings, Study, StudyError, StudyResult};
use diagnosis::EQUIVALENT;
use identification::{Discrimination, IdentificationSettings, RivalMachine, identify};
use machine::State;
use report::vocabulary::VerdictKind;

impl Study {
    /// Returns how well the candidates of a plan discriminate between the explanations that a diagnosis could
    /// not distinguish, and their names. `None` where no diagnosis is given.
    ///
    /// # Errors  the diagnosis is incomplete, of another version, machine or set, or leaves nothing to
    ///   settle; modes are planned.
    pub(super) fn discrimination(
        &self,
        request: &PlanRequest,
        among: (&[ChannelNames], &[State]),
        frfs: bool,
    ) -> StudyResult<Option<(Discrimination, Vec<String>)>> {
        let Some((diagnosis, file)) = &request.diagnosis else { return Ok(None) };
        let name = file.as_ref().map_or("the diagnosis", |file| &file.path);
        let fault = |text: String| Err(StudyError::input(name, text));
        check_current(name, &diagnosis.stamp, ("diagnosis", "diagnose"))?;
        let same = diagnosis.machine.as_ref().is_some_and(|machine| machine.text == self.config.text);
        if !same || (&diagnosis.stamp.overrides, &diagnosis.stamp.without) != (&self.overrides, &self.without)
        {
            return fault(format!(
                "is of another machine than «{}»; diagnose this one",
                self.config.machine.title
            ));
        }
        let now = self.inputs();
        if let Some(input) = diagnosis.stamp.inputs.iter().find(|input| !now.contains(input)) {
            return fault(format!(
                "is of another measurement set, or of one that has changed since ({}); diagnose again",
                input.path
            ));
        }
        if diagnosis.verdict.kind != VerdictKind::Ambiguous || diagnosis.verdict.effects.len() < 2 {
            return fault(format!(
                "has the verdict «{}», which leaves no effects to tell apart; plan without it",
                diagnosis.verdict.kind
            ));
        }
        if !frfs {
            return Err(StudyError::setting("diagnosis", "", "a verdict is settled by FRFs (data frf)"));
        }
        let study = Study {
            fit: Some(diagnosis.fit_positions.clone()),
            hold_out: Vec::new(),
            settings: Settings { fit_tolerances: false, repeats: 1, ..self.settings.clone() },
            ..self.clone()
        };
        let made = IdentificationSettings { profile: false, ..study.identification_settings()? };
        let (fit, held_out) = study.set.split(study.fit.as_deref(), &study.hold_out)?;
        let mut rivals = Vec::new();
        // The chosen model may describe the effects that it names in more detail.
        let chosen: Vec<&str> = diagnosis.chosen.effects().collect();
        let candidates = self.candidates(&diagnosis.chosen.parameters);
        for explanation in &diagnosis.verdict.effects {
            let named: Vec<&str> = explanation.split('+').collect();
            let effects = if named.iter().all(|id| chosen.contains(id)) { chosen.clone() } else { named };
            let machine = self.config.machine.with_chosen(effects, &candidates).ok_or_else(|| {
                StudyError::input(
                    name,
                    format!("names «{explanation}», which the machine cannot have; diagnose again"),
                )
            })?;
            let found = identify(&machine, &fit, &held_out, &made, &self.control)?;
            rivals.push(RivalMachine { name: explanation.clone(), machine, values: found.values });
        }
        let (plan, settings) = self.planned_frf(request)?;
        let variance = diagnosis.chosen.misfit_over_null.unwrap_or(1.0).max(1.0);
        let modes = made.frf.is_none().then_some(made.settings);
        let found = Discrimination::of_frfs(
            &rivals,
            (&fit, &made.frozen),
            among,
            plan,
            (settings, modes),
            (EQUIVALENT, variance),
        )?;
        Ok(Some((found, rivals.into_iter().map(|rival| rival.name).collect())))
    }
}
