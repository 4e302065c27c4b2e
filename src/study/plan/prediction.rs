//! Natural frequencies that a plan is to predict.

use super::{ChannelNames, PlanRequest};
use crate::predict::Evaluation;
use crate::simulation::Place;
use crate::{Study, StudyError, StudyResult};
use machine::{Operating, ParameterValues};

/// Step of the central differences in the unit interval of a parameter (1).
const STEP: f64 = 1e-4;

impl Study {
    /// Returns the derivatives of the logarithms of the natural frequencies at the positions to predict with
    /// respect to the unit intervals of the free parameters.
    ///
    /// # Errors  a position lies outside the screw; the machine has no mode in the band.
    pub(super) fn predicted_frequencies(
        &self,
        request: &PlanRequest,
        values: &ParameterValues,
        free: &[usize],
        channel: &ChannelNames,
    ) -> StudyResult<Vec<Vec<f64>>> {
        if request.predict_at_m.is_empty() {
            return Ok(Vec::new());
        }
        let machine = &self.config.machine;
        let places: Vec<Place> = request.predict_at_m.iter().copied().map(Place::Nut).collect();
        let places = self.predicted_places(&places, &[]).map_err(|error| match error {
            StudyError::Setting { key, given, fault } if key == "nut_m" => {
                StudyError::Setting { key: "predict_at".into(), given, fault }
            }
            other => other,
        })?;
        let band_hz = self.predicted_band(request.band_hz)?;
        let point = |name: &String| {
            machine
                .point(name)
                .ok_or_else(|| StudyError::setting("channels", name, "is not a point of the machine"))
        };
        let channel = (point(&channel.0)?, point(&channel.1)?);
        let evaluation = Evaluation::new(machine, channel, self.quantity(), self.settings.rods, band_hz)?;
        let mut space = evaluation.space();
        let mut slopes: Vec<Vec<f64>> = Vec::new();
        for place in &places {
            let operating = Operating::at(place.nut_m);
            let mut modes = |values: &ParameterValues| evaluation.modes(values, &operating, &mut space);
            let here = modes(values);
            let first = slopes.len();
            slopes.extend(here.iter().filter(|mode| mode.is_below(band_hz.1)).map(|_| vec![0.0; free.len()]));
            for (column, index) in free.iter().enumerate() {
                let parameter = &machine.parameters[*index];
                let unit = parameter.to_unit(values[*index]);
                let (low, high) = ((unit - STEP).max(0.0), (unit + STEP).min(1.0));
                let mut moved = |unit: f64| {
                    let mut moved = values.clone();
                    moved[*index] = parameter.from_unit(unit);
                    modes(&moved)
                };
                let (below, above) = (moved(low), moved(high));
                for (mode, slopes) in here.iter().zip(&mut slopes[first..]) {
                    let same = |of: &[report::prediction::NaturalMode]| {
                        let distance = |hz: f64| (hz / mode.natural_hz).ln();
                        of.iter().map(|m| distance(m.natural_hz)).min_by(|a, b| a.abs().total_cmp(&b.abs()))
                    };
                    slopes[column] = same(&above)
                        .zip(same(&below))
                        .map_or(0.0, |(above, below)| (above - below) / (high - low));
                }
            }
        }
        if slopes.is_empty() {
            return Err(StudyError::setting(
                "predict_at",
                "",
                "the machine has no natural frequency in the band; widen the band",
            ));
        }
        Ok(slopes)
    }
}
