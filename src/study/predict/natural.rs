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
}
