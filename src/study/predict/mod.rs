//! Prediction: natural modes, FRFs and static stiffness of an identified machine at any position, with
//! intervals.

mod evaluate;
mod natural;
mod request;
mod sample;

use std::collections::BTreeMap;
use std::path::Path;

pub(crate) use self::evaluate::Evaluation;
pub use self::request::PredictionRequest;
use self::request::{DRAWS_RANGE, MOST_PLACES};
use self::sample::PredictedPlace;
use crate::identified::{check_current, check_identification, settings_of};
use crate::modal_density::mode_frequencies_hz;
use crate::settings::checked_band;
use crate::simulation::{Place, checked_nut};
use crate::stamp::changed_input;
use crate::{Study, StudyError, StudyResult};
use identification::{Drawing, Place as Minimum, PosteriorDraw, PosteriorSample, draw_posterior};
use machine::Operating;
use measurement::{Gain, Quantity};
use numeric::statistics::extremes;
use report::document::IdentificationDocument;
use report::prediction::PredictionDocument;
use report::vocabulary::ObjectiveKind;

/// Ids of drawn parameters, tolerances included, and drawn machines: the number of the minimum about which each
/// was drawn, and its values.
pub type DrawnMachines = (Vec<String>, Vec<(usize, Vec<f64>)>);

impl Study {
    /// Predicts natural modes and static stiffness of an identified machine at places of the nut, each with
    /// its 95 % interval.
    ///
    /// # Errors  as [`Study::predict_with`].
    pub fn predict(
        &self,
        identified: &IdentificationDocument,
        places: &[Place],
    ) -> StudyResult<PredictionDocument> {
        self.predict_with(
            identified,
            &PredictionRequest { places: places.to_vec(), ..PredictionRequest::default() },
        )
    }

    /// As [`Study::predict`], with FRFs on request.
    ///
    /// # Errors  the identification is incomplete, of another version, or of another machine or measurement
    ///   set than this study's; a place is outside
    /// the screw; a setting is outside its range.
    pub fn predict_with(
        &self,
        identified: &IdentificationDocument,
        request: &PredictionRequest,
    ) -> StudyResult<PredictionDocument> {
        let study = self.with_posterior_of(identified, &request.name())?;
        if !DRAWS_RANGE.contains(&request.draws) {
            let fault = format!("write a number from {} to {}", DRAWS_RANGE.start(), DRAWS_RANGE.end());
            return Err(StudyError::setting("draws", request.draws, fault));
        }
        let made = study.identification_settings()?;
        let (fit, _) = study.set.split(study.fit.as_deref(), &study.hold_out)?;
        let places = study.predicted_places(&request.places, fit.positions())?;
        let band_hz = study.predicted_band(request.band_hz)?;
        let machine = &study.config.machine;
        let sample =
            study.sample(identified, &request.name(), (request.draws, request.seed, request.drawing))?;
        if sample.draws.iter().any(|drawn| drawn.len() < *DRAWS_RANGE.start()) {
            return Err(StudyError::Stopped);
        }
        let (response, excitation) = study.channel()?;
        let quantity = study.quantity();
        let evaluation =
            Evaluation::new(&sample.machine, (response, excitation), quantity, study.settings.rods, band_hz)?;
        let nut_sd_m = if made.tolerances { study.set.tolerance.nut_m } else { 0.0 };
        let mut positions = BTreeMap::new();
        for (at, place) in places.iter().enumerate() {
            let nut = (nut_sd_m, request.seed.wrapping_add(1 + at as u64));
            let predicted = sample::predict(&evaluation, &sample, place, nut, request)?;
            positions.insert(place.name.clone(), predicted);
        }
        let mut warnings: Vec<String> =
            identified.stamp.warnings.iter().filter(|w| w.starts_with("χ²")).cloned().collect();
        warnings.extend(study.reach_warning(&places));
        let mut stamp = study.stamp("prediction", request.seed, sample.complete, warnings);
        stamp.inputs.extend(request.file.clone());
        Ok(PredictionDocument {
            stamp,
            result: request.file.clone(),
            quantity: quantity.word().into(),
            response: machine.points[response].name.clone(),
            excitation: machine.points[excitation].name.clone(),
            band_hz: [band_hz.0, band_hz.1],
            draws: sample.draws.iter().map(Vec::len).min().unwrap_or(0),
            minima: sample.draws.len(),
            nut_sd_m,
            positions,
        })
    }

    /// Draws machines that data and tolerances leave possible: `count` about each minimum, which are those of the
    /// document.
    ///
    /// # Errors  as [`Study::predict_with`]; a bootstrap of modes.
    pub fn draw(
        &self,
        identified: &IdentificationDocument,
        (count, seed, drawing): (usize, u64, Drawing),
    ) -> StudyResult<DrawnMachines> {
        let study = self.with_posterior_of(identified, "the identification")?;
        let sample = study.sample(identified, "the identification", (count, seed, drawing))?;
        let ids = sample.machine.parameters.iter().map(|p| p.id.clone()).collect();
        let of_minimum = |(at, draws): (usize, &Vec<PosteriorDraw>)| {
            draws.iter().map(move |draw| (at, draw.values.0.clone())).collect::<Vec<_>>()
        };
        Ok((ids, sample.draws.iter().enumerate().flat_map(of_minimum).collect()))
    }

    /// Draws machines from the posterior of an identification of this study.
    fn sample(
        &self,
        identified: &IdentificationDocument,
        name: &str,
        draws: (usize, u64, Drawing),
    ) -> StudyResult<PosteriorSample> {
        let Some(posterior) = &identified.posterior else {
            return Err(StudyError::impossible("no posterior"));
        };
        let (fit, _) = self.set.split(self.fit.as_deref(), &self.hold_out)?;
        let minima: Vec<Minimum> = posterior.minima.iter().map(|place| Minimum(place.clone())).collect();
        let estimate = self.identified_values(Path::new(name), identified)?;
        let (machine, made) = (&self.config.machine, self.identification_settings()?);
        Ok(draw_posterior(
            machine,
            &fit,
            &made,
            (&estimate, &minima, posterior.variance),
            draws,
            &self.control,
        )?)
    }

    /// Returns the study with split and settings of an identification, after all checks that its posterior is
    /// that of this machine and set.
    ///
    /// # Errors  the result is incomplete, of motion records, of another version, machine or measurement set,
    ///   or has no posterior.
    pub(crate) fn with_posterior_of(
        &self,
        identified: &IdentificationDocument,
        name: &str,
    ) -> StudyResult<Study> {
        let fault = |text: String| Err(StudyError::input(name, text));
        check_identification(Path::new(name), identified)?;
        check_current(name, &identified.stamp, ("identification", "identify"))?;
        if !identified.records.is_empty() {
            return fault("is of motion records; name an identification from FRFs or modes".into());
        }
        let Some(posterior) = &identified.posterior else {
            return fault(match identified.settings.objective {
                ObjectiveKind::Eq26 => "has no intervals: the objective eq26 is no likelihood; identify with least-squares".into(),
                _ => "lacks the covariance of what was fitted (posterior), which versions before this one did not write; identify again"
                    .into(),
            });
        };
        if !self.is_machine_of(identified) {
            let title = &self.config.machine.title;
            return fault(format!(
                "is of another machine than «{title}»: text, overrides or removed effects of its description differ; identify again"
            ));
        }
        if self.outdated_machine().is_some() {
            return fault(format!(
                "is of a machine whose file {} has changed since; identify again",
                self.config.path
            ));
        }
        if let Some(path) = changed_input(&self.inputs(), &identified.stamp.inputs) {
            return fault(format!("is of a measurement set that has changed since ({path}); identify again"));
        }
        let settings = settings_of(identified);
        let fit_tolerances = posterior
            .coordinates
            .iter()
            .any(|c| c.of_machine && !identified.parameters.contains_key(&c.name));
        let (fit, hold_out) = (identified.settings.positions.clone(), identified.settings.hold_out.clone());
        let mut study =
            Study { fit, hold_out, settings: crate::Settings { fit_tolerances, ..settings }, ..self.clone() };
        // The checks above refuse what this warning is about.
        study.config.warnings.retain(|w| !w.contains("has changed since the result"));
        Ok(study)
    }

    /// Returns the places to predict, each once.
    pub(crate) fn predicted_places(
        &self,
        places: &[Place],
        fitted: &[usize],
    ) -> StudyResult<Vec<PredictedPlace>> {
        let (set, machine) = (&self.set, &self.config.machine);
        let mut wanted = places.to_vec();
        if wanted.is_empty() {
            wanted.extend(set.positions.iter().map(|p| Place::Position(p.name.clone())));
        }
        if wanted.is_empty() {
            wanted.push(Place::MidStroke);
        }
        if wanted.len() > MOST_PLACES {
            return Err(StudyError::setting(
                "nut_m",
                "",
                format!("{} positions are too many; write at most {MOST_PLACES}", wanted.len()),
            ));
        }
        let mut found: Vec<PredictedPlace> = Vec::new();
        for place in &wanted {
            let (name, nut_m, fit) = match place {
                Place::Nut(nut_m) => (nut_m.to_string(), Some(*nut_m), None),
                Place::MidStroke => ("mid-stroke".to_string(), machine.stroke_m().map(|s| 0.5 * s), None),
                Place::Position(name) => {
                    let index = set.position_named(name)?;
                    (name.clone(), set.positions[index].nut_m, Some(fitted.contains(&index)))
                }
            };
            let operating = Operating::at(nut_m);
            match place {
                Place::Nut(_) => drop(checked_nut(machine, "nut_m", operating)?),
                _ => machine.check_operating("nut_m", &operating)?,
            }
            if found.iter().any(|other| other.name == name) {
                return Err(StudyError::setting("nut_m", &name, "is named twice; write each position once"));
            }
            found.push(PredictedPlace { name, nut_m, fit });
        }
        Ok(found)
    }

    /// Returns the band of a prediction: the requested one, or that of the data.
    pub(crate) fn predicted_band(&self, wanted: Option<(f64, f64)>) -> StudyResult<(f64, f64)> {
        if let Some(band_hz) = wanted {
            return checked_band(band_hz);
        }
        let within = self.settings.band_hz.unwrap_or((0.0, f64::INFINITY));
        let lines = self.set.frfs.iter().flat_map(|frf| frf.lines.iter().map(|line| line.frequency_hz));
        let lines: Vec<f64> = lines.filter(|hz| (within.0..=within.1).contains(hz)).collect();
        let (from, to) = match self.settings.fits_frfs(&self.set) {
            true => extremes(&lines),
            false => {
                let (low, high) = extremes(&mode_frequencies_hz(&self.set));
                (0.5 * low, 1.1 * high)
            }
        };
        // Around a single line a band of an octave, half of it on either side.
        let half = if from == to { std::f64::consts::SQRT_2 } else { 1.0 };
        if to >= from {
            Ok((from / half, to * half))
        } else {
            Err(StudyError::setting("band_hz", "", "the data have no band; write one, such as 5,1000"))
        }
    }

    /// Returns response and excitation of the set (points of the machine). Of closed-loop FRFs the response
    /// is also the excitation: predicted is the machine without its loops.
    fn channel(&self) -> StudyResult<(usize, usize)> {
        let (set, machine) = (&self.set, &self.config.machine);
        let first = set.frfs.first();
        let named = |own: &Option<String>, of_first: Option<&String>, key: &str| {
            let name = own
                .as_ref()
                .or(of_first)
                .ok_or_else(|| StudyError::input(&set.path, format!("names no {key}")))?;
            machine.point(name).ok_or_else(|| {
                StudyError::input(&set.path, format!("{key} «{name}» is not a point of the machine"))
            })
        };
        let response = named(&set.response, first.map(|f| &f.response), "response")?;
        if self.is_commanded() {
            return Ok((response, response));
        }
        Ok((response, named(&set.excitation, first.map(|f| &f.excitation), "excitation")?))
    }

    /// Returns the quantity of the set, or that of its first FRF.
    pub fn quantity(&self) -> Quantity {
        self.set
            .quantity
            .or_else(|| self.set.frfs.first().map(|frf| frf.quantity))
            .unwrap_or(Quantity::Receptance)
    }

    /// Warns of amplitudes that the set measures with an unknown gain, and of places beyond the outermost
    /// measured ones.
    fn reach_warning(&self, places: &[PredictedPlace]) -> Vec<String> {
        let (low, high) = extremes(self.set.positions.iter().filter_map(|p| p.nut_m.as_ref()));
        let beyond: Vec<&str> = places
            .iter()
            .filter(|p| p.nut_m.is_some_and(|x| x < low || x > high))
            .map(|p| p.name.as_str())
            .collect();
        let mut warnings = Vec::new();
        if !beyond.is_empty() && low <= high {
            warnings.push(format!(
                "{} lies beyond the measured positions ({low} to {high} m): no measurement there supports the model",
                beyond.join(", ")
            ));
        }
        if self.is_commanded() {
            warnings
                .push("the set holds closed-loop FRFs: predicted are modes and FRFs of a force on the response, without the loops".into());
        }
        if self.set.gain == Gain::Unknown {
            warnings.push(
                "the gain of the set is unknown: predicted amplitudes are those of the machine, without it"
                    .into(),
            );
        }
        warnings
    }
}
