//! Natural modes of an identified machine at the positions of its measurement set.

use std::collections::BTreeMap;

use super::evaluate::Evaluation;
use crate::{Study, StudyResult};
use identification::Identification;
use machine::Operating;
use report::prediction::NaturalMode;

impl Study {
    /// Computes the natural modes of a fitted machine at all positions of the set, with nut positions as stated.
    pub(crate) fn natural_modes(&self, found: &Identification) -> StudyResult<BTreeMap<String, Vec<NaturalMode>>> {
        let band_hz = self.predicted_band(None)?;
        let evaluation = Evaluation::new(&found.machine, self.channel()?, self.quantity(), self.settings.rods, band_hz)?;
        let mut space = evaluation.space();
        let mut of = |nut_m: Option<f64>| {
            let modes = evaluation.modes(&found.values, &Operating::at(nut_m), &mut space);
            modes.into_iter().filter(|m| m.frequency_hz <= band_hz.1).collect::<Vec<NaturalMode>>()
        };
        if self.set.positions.is_empty() || self.config.machine.stroke_m().is_none() {
            return Ok([("all".to_string(), of(self.config.machine.stroke_m().map(|s| 0.5 * s)))].into());
        }
        Ok(self.set.positions.iter().map(|p| (p.name.clone(), of(p.nut_m))).collect())
    }

    /// Returns a warning where no natural frequency lies in the band of the FRFs.
    pub(crate) fn modeless_warning(&self, modes: &BTreeMap<String, Vec<NaturalMode>>) -> StudyResult<Option<String>> {
        let (from, to) = self.predicted_band(None)?;
        let inside = modes.values().flatten().any(|mode| (from..=to).contains(&mode.frequency_hz));
        let warning = || {
            format!(
                "no natural frequency of the fitted machine lies in the band of the FRFs, {from:.4} to {to:.4} Hz: stiffness and damping of the joints \
                 show at resonances; measure a band that holds some"
            )
        };
        Ok((!inside).then(warning))
    }
}
