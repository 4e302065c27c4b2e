//! Objectives on natural frequencies and amplitudes.

use std::sync::{Arc, Mutex};

use super::pairing::{MISSING, Pair, VISIBLE, pair};
use super::{GAIN_RANGE, ObjectiveError, free_parameters, point_named};
use crate::machine::{FitRule, Machine, Operating};
use crate::measurement::{FitSet, Gain, HoldOutSet, MeasurementSet, ModeObservation};
use crate::model::{Network, Peak, PeakSearch, Rods, Structure, Workspace, peaks};

/// Which function of the deviations is made least.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Objective {
    /// Σ r²: relative frequency errors over σ_f and ln-amplitude errors over σ_lnA.
    LeastSquares,
    /// √Σ[(Δf/f)² + (ΔA/A)²] as printed. Source: Tian et al., Eq. 26.
    Eq26,
    /// [`Objective::LeastSquares`] on the frequencies alone.
    Frequencies,
}

/// Weights and options of a mode objective.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeSettings {
    /// Which function.
    pub objective: Objective,
    /// Relative standard deviation of a frequency that the model itself causes.
    pub frequency_model_error: f64,
    /// Standard deviation of ln(amplitude).
    pub amplitude_sd: f64,
    /// How rods are represented.
    pub rods: Rods,
}

impl Default for ModeSettings {
    /// σ_f² = (0.29·resolution/f)² + (1 %)² and σ_lnA = 0.13: rounding and a model error, by the scatter of the published bench.
    fn default() -> Self {
        ModeSettings { objective: Objective::LeastSquares, frequency_model_error: 0.01, amplitude_sd: 0.13, rods: Rods::Exact }
    }
}

/// Deviation of one order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// The observation; `None` for a predicted peak without a partner.
    pub observed: Option<ModeObservation>,
    /// The predicted peak; its amplitude in the measured quantity, without gain.
    pub predicted: Option<Peak>,
    /// A peak without a partner that should have been seen.
    pub unexpected: bool,
}

/// The prediction for a position beside its measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionPrediction {
    /// Index of the position in the set.
    pub position: usize,
    /// All predicted peaks of the band.
    pub peaks: Vec<Peak>,
    /// Orders and peaks, aligned, in rising frequency.
    pub deviations: Vec<Deviation>,
}

/// How the gain came about and how well amplitudes agree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AmplitudeFit {
    /// Factor from predicted to measured amplitudes.
    pub gain: f64,
    /// Amplitudes it rests on.
    pub count: usize,
}

/// Room for one evaluation.
struct Scratch {
    network: Network,
    work: Workspace,
}

struct PositionData {
    index: usize,
    operating: Operating,
    observed: Vec<ModeObservation>,
    measured_hz: Vec<f64>,
}

/// Distance between predicted peaks and measured modes of some positions, as a function of a machine's free parameters.
pub struct ModeObjective<'m> {
    machine: &'m Machine,
    structure: Arc<Structure>,
    settings: ModeSettings,
    positions: Vec<PositionData>,
    gain: Gain,
    resolution_hz: f64,
    search: PeakSearch,
    /// Lowest and highest measured frequency of these positions (Hz).
    pub band_hz: (f64, f64),
    /// Indices of the parameters that are free.
    pub free: Vec<usize>,
    base: Vec<f64>,
    pool: Mutex<Vec<Scratch>>,
}

impl<'m> ModeObjective<'m> {
    /// For the positions to be fitted; `frozen` parameters keep their start values.
    ///
    /// # Errors  the set has no modes there, names points the machine lacks, or lies outside the screw.
    pub fn new(machine: &'m Machine, fit: &FitSet<'_>, settings: ModeSettings, frozen: &[String]) -> Result<Self, ObjectiveError> {
        if fit.positions.is_empty() {
            return Err(ObjectiveError::Data(format!(
                "{}: no position is named to fit; write some into split.fit or --positions",
                fit.set.path
            )));
        }
        let objective = Self::over(machine, fit.set, &fit.positions, settings, frozen, None)?;
        if objective.positions.iter().all(|p| p.measured_hz.is_empty()) {
            return Err(ObjectiveError::Data("no mode was observed at the positions to fit; name others with --positions".into()));
        }
        Ok(objective)
    }

    /// For the held-out positions: to predict, not to fit; over the band of the fit, too, where that is given.
    ///
    /// # Errors  as [`ModeObjective::new`].
    pub fn held_out(
        machine: &'m Machine,
        held_out: &HoldOutSet<'_>,
        settings: ModeSettings,
        fit_band_hz: Option<(f64, f64)>,
    ) -> Result<Self, ObjectiveError> {
        let objective = Self::over(machine, held_out.set, &held_out.positions, settings, &[], fit_band_hz)?;
        if !objective.band_hz.0.is_finite() {
            return Err(ObjectiveError::Data(format!(
                "{}: no mode was observed at these positions; there is nothing to check",
                held_out.set.path
            )));
        }
        Ok(objective)
    }

    fn over(
        machine: &'m Machine,
        set: &MeasurementSet,
        positions: &[usize],
        settings: ModeSettings,
        frozen: &[String],
        wider: Option<(f64, f64)>,
    ) -> Result<Self, ObjectiveError> {
        let table = set
            .modes
            .as_ref()
            .ok_or_else(|| ObjectiveError::Data(format!("{}: the set has no modes; write modes = \"…\" in its manifest", set.path)))?;
        let named = |name: &Option<String>, key: &str| point_named(machine, &set.path, key, name.as_deref().unwrap_or_default());
        let (response, excitation) = (named(&set.response, "response")?, named(&set.excitation, "excitation")?);
        let structure = Arc::new(Structure::new(machine, response, excitation, settings.rods)?);
        let mut data = Vec::new();
        for &index in positions {
            let operating = Operating::at(set.positions[index].nut_m);
            machine.check_operating(&format!("{}: position {}", set.path, set.positions[index].name), &operating)?;
            let observed: Vec<ModeObservation> = table.positions[index].iter().filter(|m| m.frequency_hz.is_some()).copied().collect();
            let measured_hz = observed.iter().filter_map(|m| m.frequency_hz).collect();
            data.push(PositionData { index, operating, observed, measured_hz });
        }
        // The band of these positions alone: what is held out must not reach the fit.
        let all =
            || data.iter().flat_map(|p: &PositionData| p.measured_hz.iter().copied()).chain(wider.into_iter().flat_map(|(a, b)| [a, b]));
        let band_hz = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
        let search = PeakSearch {
            from_hz: 0.5 * band_hz.0,
            to_hz: 1.35 * band_hz.1,
            precision: 1e-7,
            omega_power: set.quantity.map_or(0, |q| q.power()),
        };
        let free = free_parameters(machine, frozen, |rule| rule == FitRule::Always)?;
        Ok(ModeObjective {
            machine,
            structure,
            settings,
            positions: data,
            gain: set.gain,
            resolution_hz: table.resolution_hz.unwrap_or(0.0),
            search,
            band_hz,
            free,
            base: machine.start(),
            pool: Mutex::new(Vec::new()),
        })
    }

    /// Parameters of the machine, in its order, for a place of the free ones in the unit cube.
    pub fn parameters(&self, place: &[f64]) -> Vec<f64> {
        let mut parameters = self.base.clone();
        for (&index, &u) in self.free.iter().zip(place) {
            parameters[index] = self.machine.parameters[index].from_unit(u.clamp(0.0, 1.0));
        }
        parameters
    }

    /// Number of frequencies and amplitudes that are compared.
    pub fn observations(&self) -> usize {
        let amplitudes = |p: &PositionData| p.observed.iter().filter(|m| m.amplitude.is_some()).count();
        self.positions
            .iter()
            .map(|p| p.measured_hz.len() + if self.settings.objective == Objective::Frequencies { 0 } else { amplitudes(p) })
            .sum()
    }

    /// Whether the gain is estimated along.
    pub fn estimates_gain(&self) -> bool {
        self.gain == Gain::Unknown
            && self.settings.objective != Objective::Frequencies
            && self.positions.iter().any(|p| p.observed.iter().any(|m| m.amplitude.is_some()))
    }

    /// Predictions for all positions with the given parameters.
    pub fn predict(&self, parameters: &[f64]) -> Vec<PositionPrediction> {
        self.predict_while(parameters, |_| true)
    }

    /// Predictions for one position after another, as long as those so far are worth going on.
    fn predict_while(&self, parameters: &[f64], mut go_on: impl FnMut(&[PositionPrediction]) -> bool) -> Vec<PositionPrediction> {
        let pooled = self.pool.lock().ok().and_then(|mut pool| pool.pop());
        let mut scratch = pooled.unwrap_or_else(|| Scratch { network: self.structure.network(), work: self.structure.workspace() });
        let mut predictions = Vec::with_capacity(self.positions.len());
        for position in &self.positions {
            predictions.push(self.predict_one(position, parameters, &mut scratch));
            if !go_on(&predictions) {
                break;
            }
        }
        if let Ok(mut pool) = self.pool.lock() {
            pool.push(scratch);
        }
        predictions
    }

    fn predict_one(&self, p: &PositionData, parameters: &[f64], scratch: &mut Scratch) -> PositionPrediction {
        scratch.network.update(self.machine, parameters, &p.operating);
        let peaks = peaks(&scratch.network, self.search, &mut scratch.work);
        let predicted_hz: Vec<f64> = peaks.iter().map(|p| p.frequency_hz).collect();
        let alone: Vec<f64> = peaks.iter().map(|p| if self.unexpected(p) { MISSING } else { 0.0 }).collect();
        let deviations = pair(&p.measured_hz, &predicted_hz, &alone)
            .into_iter()
            .map(|Pair { measured, predicted }| Deviation {
                observed: measured.map(|i| p.observed[i]),
                predicted: predicted.map(|i| peaks[i]),
                unexpected: measured.is_none() && predicted.is_some_and(|i| self.unexpected(&peaks[i])),
            })
            .collect();
        PositionPrediction { position: p.index, peaks, deviations }
    }

    /// Whether a predicted peak without a partner should have been seen.
    fn unexpected(&self, peak: &Peak) -> bool {
        peak.prominence >= VISIBLE && peak.frequency_hz >= 0.9 * self.band_hz.0 && peak.frequency_hz <= 1.1 * self.band_hz.1
    }

    /// Standard deviation of a relative frequency error.
    fn frequency_sd(&self, frequency_hz: f64) -> f64 {
        (0.29 * self.resolution_hz / frequency_hz).hypot(self.settings.frequency_model_error)
    }

    /// The gain that suits the predictions best, in the sense of the objective.
    pub fn amplitude_fit(&self, predictions: &[PositionPrediction]) -> AmplitudeFit {
        if self.settings.objective == Objective::Frequencies {
            return AmplitudeFit { gain: 1.0, count: 0 };
        }
        let ratios = predictions.iter().flat_map(|p| &p.deviations).filter_map(|d| Some((d.observed?.amplitude?, d.predicted?.amplitude)));
        let (mut count, mut log_sum, mut sum, mut square) = (0, 0.0, 0.0, 0.0);
        for (measured, predicted) in ratios {
            count += 1;
            log_sum += (measured / predicted).ln();
            sum += predicted / measured;
            square += (predicted / measured) * (predicted / measured);
        }
        let gain = match (self.gain, count, self.settings.objective) {
            (Gain::Known(gain), _, _) => gain,
            (Gain::Unknown, 0, _) => 1.0,
            (Gain::Unknown, _, Objective::Eq26) => sum / square,
            (Gain::Unknown, n, _) => (log_sum / n as f64).exp(),
        };
        AmplitudeFit { gain, count }
    }

    /// Residuals, weighted, in a fixed order: for each position the frequencies, then the amplitudes, then a last one for peaks that
    /// have no partner.
    pub fn residuals(&self, predictions: &[PositionPrediction], gain: f64) -> Vec<f64> {
        let missing = MISSING / self.settings.frequency_model_error.max(1e-6);
        let mut residuals = Vec::new();
        for prediction in predictions {
            let mut amplitudes = Vec::new();
            let mut extra = 0.0;
            for deviation in &prediction.deviations {
                match (deviation.observed, deviation.predicted) {
                    (Some(observed), Some(peak)) => {
                        let measured_hz = observed.frequency_hz.unwrap_or(peak.frequency_hz);
                        residuals.push((peak.frequency_hz / measured_hz - 1.0) / self.frequency_sd(measured_hz));
                        if let Some(amplitude) = observed.amplitude {
                            amplitudes.push((gain * peak.amplitude / amplitude).ln() / self.settings.amplitude_sd);
                        }
                    }
                    (Some(observed), None) => {
                        residuals.push(missing);
                        amplitudes.extend(observed.amplitude.map(|_| 0.0));
                    }
                    (None, Some(peak)) => extra += if self.unexpected(&peak) { missing * missing } else { 0.0 },
                    (None, None) => {}
                }
            }
            if self.settings.objective != Objective::Frequencies {
                residuals.append(&mut amplitudes);
            }
            residuals.push(f64::sqrt(extra));
        }
        residuals
    }

    /// Deviations of free parameters from what is known of them beforehand, over its standard deviation.
    pub fn prior(&self, parameters: &[f64]) -> Vec<f64> {
        let described = |i: &usize| &self.machine.parameters[*i];
        self.free.iter().filter_map(|i| Some((parameters[*i] - described(i).start) / described(i).sd?)).collect()
    }

    /// A place of the free parameters, with the best coordinate of the gain added where that is unknown.
    pub fn extended(&self, place: &[f64]) -> Vec<f64> {
        let mut extended = place.to_vec();
        if self.estimates_gain() {
            let gain = self.amplitude_fit(&self.predict(&self.parameters(place))).gain;
            extended.push(((gain / GAIN_RANGE.0).ln() / (GAIN_RANGE.1 / GAIN_RANGE.0).ln()).clamp(0.0, 1.0));
        }
        extended
    }

    /// The gain at a place that was [`ModeObjective::extended`].
    pub fn gain(&self, place: &[f64]) -> f64 {
        match (self.gain, place.get(self.free.len())) {
            (Gain::Known(gain), _) => gain,
            (Gain::Unknown, Some(u)) => GAIN_RANGE.0 * (u * (GAIN_RANGE.1 / GAIN_RANGE.0).ln()).exp(),
            (Gain::Unknown, None) => 1.0,
        }
    }

    /// All weighted residuals at a place that was [`ModeObjective::extended`].
    pub fn residuals_at(&self, place: &[f64]) -> Vec<f64> {
        let parameters = self.parameters(place);
        let mut residuals = self.residuals(&self.predict(&parameters), self.gain(place));
        residuals.extend(self.prior(&parameters));
        residuals
    }

    /// Rows of [`ModeObjective::residuals`] of each position.
    pub fn rows(&self) -> Vec<usize> {
        let counts_amplitudes = self.settings.objective != Objective::Frequencies;
        let amplitudes = |p: &PositionData| p.observed.iter().filter(|m| counts_amplitudes && m.amplitude.is_some()).count();
        self.positions.iter().map(|p| p.measured_hz.len() + amplitudes(p) + 1).collect()
    }

    /// Whether the sum of its squared residuals is a likelihood, so that intervals can be told.
    pub fn is_likelihood(&self) -> bool {
        self.settings.objective != Objective::Eq26
    }

    /// The objective at these parameters; always finite.
    pub fn cost(&self, parameters: &[f64]) -> f64 {
        self.cost_of(&self.predict(parameters), parameters)
    }

    /// The objective at these parameters where it is at most `limit`, otherwise something above it. With the gain at its best for the positions so
    /// far, a sum of squares can only grow with every further one.
    pub fn cost_at_most(&self, parameters: &[f64], limit: f64) -> f64 {
        let mut cost = 0.0;
        self.predict_while(parameters, |predictions| {
            cost = self.cost_of(predictions, parameters);
            // Eq. 26 is no sum of squares with its gain at its best: no part of it tells of the whole.
            self.settings.objective == Objective::Eq26 || cost <= limit * (1.0 + 1e-9)
        });
        cost
    }

    /// The objective of predictions for some positions.
    fn cost_of(&self, predictions: &[PositionPrediction], parameters: &[f64]) -> f64 {
        let gain = self.amplitude_fit(predictions).gain;
        match self.settings.objective {
            Objective::LeastSquares | Objective::Frequencies => {
                let data: f64 = self.residuals(predictions, gain).iter().map(|r| r * r).sum();
                data + self.prior(parameters).iter().map(|r| r * r).sum::<f64>()
            }
            Objective::Eq26 => {
                let mut sum = 0.0;
                for deviation in predictions.iter().flat_map(|p| &p.deviations) {
                    sum += match (deviation.observed, deviation.predicted) {
                        (Some(observed), Some(peak)) => {
                            let frequency = observed.frequency_hz.map_or(0.0, |f| peak.frequency_hz / f - 1.0);
                            let amplitude = observed.amplitude.map_or(0.0, |a| (gain * peak.amplitude / a - 1.0).clamp(-1e3, 1e3));
                            frequency * frequency + amplitude * amplitude
                        }
                        // A mode that is not predicted: both of its terms are 1.
                        (Some(observed), None) => 1.0 + f64::from(u8::from(observed.amplitude.is_some())),
                        _ => 0.0,
                    };
                }
                f64::sqrt(sum)
            }
        }
    }
}
