//! Natural modes of an identified machine at the positions of its measurement set.

use std::collections::BTreeMap;

use super::evaluate::Evaluation;
use crate::{Study, StudyResult};
use identification::Identification;
use machine::Operating;
use measurement::Frf;
use numeric::statistics::extremes;
use report::prediction::NaturalMode;

impl Study {
    /// Computes the natural modes of a fitted machine at all positions of the set, with nut positions as
    /// stated.
    pub(crate) fn natural_modes(
        &self,
        found: &Identification,
    ) -> StudyResult<BTreeMap<String, Vec<NaturalMode>>> {
        let band_hz = self.predicted_band(None)?;
        let evaluation =
            Evaluation::new(&found.machine, self.channel()?, self.quantity(), self.settings.rods, band_hz)?;
        let mut space = evaluation.space();
        let mut of = |nut_m: Option<f64>| {
            let modes = evaluation.modes(&found.values, &Operating::at(nut_m), &mut space);
            modes.into_iter().filter(|m| m.is_below(band_hz.1)).collect::<Vec<NaturalMode>>()
        };
        if self.set.positions.is_empty() || self.config.machine.stroke_m().is_none() {
            return Ok([("all".to_string(), of(self.config.machine.stroke_m().map(|s| 0.5 * s)))].into());
        }
        Ok(self.set.positions.iter().map(|p| (p.name.clone(), of(p.nut_m))).collect())
    }

    /// Returns a warning where no natural frequency lies in the band of any FRF; `None` for FRFs of one line.
    pub(crate) fn modeless_warning(&self, modes: &BTreeMap<String, Vec<NaturalMode>>) -> Option<String> {
        let within = self.settings.band_hz.unwrap_or((0.0, f64::INFINITY));
        let band = |frf: &Frf| {
            extremes(
                frf.lines
                    .iter()
                    .map(|line| &line.frequency_hz)
                    .filter(|hz| (within.0..=within.1).contains(*hz)),
            )
        };
        let bands: Vec<(f64, f64)> = self.set.frfs.iter().map(band).filter(|(from, to)| to > from).collect();
        let inside = |mode: &NaturalMode| {
            let hz = mode.frequency_hz.unwrap_or(mode.natural_hz);
            bands.iter().any(|(from, to)| (*from..=*to).contains(&hz))
        };
        if bands.is_empty() || modes.values().flatten().any(inside) {
            return None;
        }
        let (from, to) = extremes(bands.iter().flat_map(|(from, to)| [from, to]));
        Some(format!(
            "no natural frequency of the fitted machine lies in the band of the FRFs, {from:.1} to {to:.1} Hz: stiffness and damping of the joints show \
             at resonances; measure a band that holds some"
        ))
    }
}
