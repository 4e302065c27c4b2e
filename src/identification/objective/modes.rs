//! Objectives on natural frequencies and amplitudes.

use nalgebra::{DMatrix, DVector};
use std::sync::{Arc, Mutex};

use super::ObjectiveError;
use super::closed_loop::Excitation;
use super::mode_settings::{ModeSettings, Objective};
use super::pairing::{Deviation, MISSING, ModePair, PredictedPeak, VISIBLE, pair_into};
use super::setup::{GAIN_RANGE, free_parameters, keep_rods, point_named};
use crate::Place;
use dynamics::model::{AssembledModel, FrequencyGrid, Peak, PeakSearch, Structure, Workspace, peaks_into};
use machine::{Chain, FitRule, Machine, Operating, ParameterValues};
use measurement::{FitSet, Gain, HoldOutSet, MeasurementSet, ModeObservation};
use numeric::unit::omega_rad_s;

/// Prediction and measurement of a position.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PositionPrediction {
    /// Index of the position in the set.
    pub position: usize,
    /// All predicted peaks of the band.
    pub peaks: Vec<Peak>,
    /// Pairs of observation and peak, in rising frequency.
    pub deviations: Vec<Deviation>,
}

/// Gain of the measured amplitudes, and the number of amplitudes behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AmplitudeFit {
    /// Factor from predicted to measured amplitudes.
    pub gain: f64,
    /// Number of amplitudes from which it is computed.
    pub count: usize,
}

/// Working memory of one evaluation, reused so that later evaluations allocate nothing.
pub(super) struct ModeScratch {
    pub(super) network: AssembledModel,
    pub(super) work: Workspace,
    pub(super) parameters: Vec<f64>,
    pub(super) predictions: Vec<PositionPrediction>,
    candidates: Vec<PredictedPeak>,
    least: Vec<f64>,
    pairs: Vec<ModePair>,
}

pub(super) struct PositionData {
    index: usize,
    pub(super) operating: Operating,
    observed: Vec<ModeObservation>,
    /// Frequency (Hz) of each order to pair with peaks; `None` for one known from other positions about which
    /// this one states nothing.
    sought: Vec<Option<f64>>,
    /// Index in `observed` of each order sought.
    observation: Vec<Option<usize>>,
    /// Initial frequencies of the peak search, with precomputed rods that no free parameter changes.
    lines: FrequencyGrid,
}

/// Misfit between predicted peaks and measured modes of some positions as a function of a machine's free
/// parameters.
pub struct ModeObjective<'m> {
    pub(super) machine: &'m Machine,
    structure: Arc<Structure>,
    pub(super) settings: ModeSettings,
    pub(super) positions: Vec<PositionData>,
    gain: Gain,
    pub(super) resolution_hz: f64,
    least_prominence: f64,
    pub(super) search: PeakSearch,
    /// Lowest and highest measured frequency of these positions (Hz).
    pub band_hz: (f64, f64),
    /// Indices of the free parameters.
    pub free: Vec<usize>,
    base: ParameterValues,
    /// Inverse of the lower Cholesky factor of the residuals' covariance, where they are correlated.
    pub(super) whitening: Option<DMatrix<f64>>,
    pool: Mutex<Vec<ModeScratch>>,
}

impl<'m> ModeObjective<'m> {
    /// Builds the objective of the positions to fit; `frozen` parameters keep their start values.
    ///
    /// # Errors  the set has no modes there, names points that the machine lacks, or lies outside the screw.
    pub fn new(
        machine: &'m Machine,
        fit: &FitSet<'_>,
        settings: ModeSettings,
        frozen: &[String],
    ) -> Result<Self, ObjectiveError> {
        if fit.positions().is_empty() {
            return Err(ObjectiveError::Data(format!(
                "{}: no position to fit is given; name some in split.fit or as positions",
                fit.set().path
            )));
        }
        let objective = Self::for_positions(machine, fit.set(), fit.positions(), settings, frozen, None)?;
        if objective.positions.iter().all(|p| p.observed.is_empty()) {
            return Err(ObjectiveError::Data(
                "no mode was observed at the positions to fit; name other positions".into(),
            ));
        }
        Ok(objective)
    }

    /// As [`ModeObjective::new`], and frees the parameters that modes hardly determine; they follow those of
    /// `first`.
    ///
    /// # Errors  as [`ModeObjective::new`].
    pub fn with_all_free(
        machine: &'m Machine,
        fit: &FitSet<'_>,
        settings: ModeSettings,
        frozen: &[String],
        first: &[usize],
    ) -> Result<Self, ObjectiveError> {
        let mut objective = Self::new(machine, fit, settings, frozen)?;
        let more = free_parameters(machine, frozen, &[], |rule| rule == FitRule::Frf)?;
        objective.free = first.iter().copied().chain(more).collect();
        objective.prepare_grids();
        Ok(objective)
    }

    /// Returns the objective with correlated residuals. Each column is their change by one standard deviation
    /// of a nuisance parameter.
    #[must_use]
    pub fn correlated(mut self, columns: &[Vec<f64>]) -> Self {
        let rows = columns.first().map_or(0, Vec::len);
        let changes = DMatrix::from_fn(rows, columns.len(), |row, column| columns[column][row]);
        let covariance = DMatrix::identity(rows, rows) + &changes * changes.transpose();
        self.whitening = covariance.cholesky().and_then(|c| c.l().try_inverse());
        self
    }

    /// Builds the objective of the held-out positions, to predict them. Its band includes that of the fit, if
    /// given.
    ///
    /// # Errors  as [`ModeObjective::new`].
    pub fn held_out(
        machine: &'m Machine,
        held_out: &HoldOutSet<'_>,
        settings: ModeSettings,
        fit_band_hz: Option<(f64, f64)>,
    ) -> Result<Self, ObjectiveError> {
        let objective =
            Self::for_positions(machine, held_out.set(), held_out.positions(), settings, &[], fit_band_hz)?;
        if !objective.band_hz.0.is_finite() {
            return Err(ObjectiveError::Data(format!(
                "{}: no mode was observed at the held-out positions; there is nothing to compare",
                held_out.set().path
            )));
        }
        Ok(objective)
    }

    fn for_positions(
        machine: &'m Machine,
        set: &MeasurementSet,
        positions: &[usize],
        settings: ModeSettings,
        frozen: &[String],
        wider: Option<(f64, f64)>,
    ) -> Result<Self, ObjectiveError> {
        let table = set.modes.as_ref().ok_or_else(|| {
            ObjectiveError::Data(format!(
                "{}: the set has no modes; write modes = \"…\" in its manifest",
                set.path
            ))
        })?;
        let named = |name: &Option<String>, key: &str| {
            point_named(machine, &set.path, key, name.as_deref().unwrap_or_default())
        };
        let named_excitation = set.excitation.as_deref().unwrap_or_default();
        if Excitation::named(machine, &set.path, named_excitation)? == Excitation::Command {
            let fault = "peaks of a closed-loop FRF are no natural frequencies of the machine; give the FRF itself as [[frf]]";
            return Err(ObjectiveError::Data(format!(
                "{}: excitation = \"{named_excitation}\": {fault}",
                set.path
            )));
        }
        let (response, excitation) =
            (named(&set.response, "response")?, named(&set.excitation, "excitation")?);
        let structure = Arc::new(Structure::new(machine, response, excitation, settings.rods)?);
        // Orders observed at any of these positions: held-out data must not influence the fit.
        let rows = || positions.iter().flat_map(|index| &table.positions[*index]);
        let mut known: Vec<u32> = rows().filter(|m| m.frequency_hz.is_some()).map(|m| m.order).collect();
        known.sort_unstable();
        known.dedup();
        let resolution_hz = table.resolution_hz.unwrap_or(0.0);
        let mut data = Vec::new();
        for &index in positions {
            let operating = Operating::at(set.positions[index].nut_m);
            machine.check_operating(
                &format!("{}: position {}", set.path, set.positions[index].name),
                &operating,
            )?;
            let stated = &table.positions[index];
            let observed: Vec<ModeObservation> =
                stated.iter().filter(|m| m.frequency_hz.is_some()).copied().collect();
            let unstated = |order: &u32| stated.iter().all(|m| m.order != *order);
            let seen = observed.iter().enumerate().map(|(at, m)| (m.order, m.frequency_hz, Some(at)));
            let mut orders: Vec<_> =
                seen.chain(known.iter().copied().filter(unstated).map(|order| (order, None, None))).collect();
            orders.sort_by_key(|(order, _, _)| *order);
            let sought = orders.iter().map(|(_, frequency_hz, _)| *frequency_hz).collect();
            let observation = orders.into_iter().map(|(_, _, at)| at).collect();
            data.push(PositionData {
                index,
                operating,
                observed,
                sought,
                observation,
                lines: FrequencyGrid::new(&[]),
            });
        }
        // The band follows from these positions alone: held-out data must not influence the fit.
        let all = || {
            data.iter()
                .flat_map(|p: &PositionData| p.observed.iter().filter_map(|m| m.frequency_hz))
                .chain(wider.into_iter().flat_map(|(a, b)| [a, b]))
        };
        let band_hz = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
        let search = PeakSearch {
            from_hz: 0.5 * band_hz.0,
            to_hz: 1.35 * band_hz.1,
            precision: 1e-9,
            omega_power: set.quantity.map_or(0, |q| q.power()),
        };
        let free = free_parameters(machine, frozen, &[], |rule| rule == FitRule::Always)?;
        let mut objective = ModeObjective {
            machine,
            structure,
            settings,
            positions: data,
            gain: set.gain,
            resolution_hz,
            least_prominence: table.least_prominence.unwrap_or(VISIBLE),
            search,
            band_hz,
            free,
            base: machine.start(),
            whitening: None,
            pool: Mutex::new(Vec::new()),
        };
        objective.prepare_grids();
        Ok(objective)
    }

    /// Prepares the frequency grids of the peak search, with precomputed rods that no free parameter changes.
    fn prepare_grids(&mut self) {
        let places = [0.3, 0.7].map(|u| self.parameters_of(&vec![u; self.free.len()]));
        for position in &mut self.positions {
            position.lines = self.search.start_grid();
            keep_rods(
                &mut position.lines,
                (self.machine, &self.structure),
                places.each_ref().map(|p| (&p[..], position.operating)),
            );
        }
    }

    /// Returns the machine's parameters, in its order, for unit-cube coordinates of the free ones.
    pub fn parameters(&self, place: &Place) -> ParameterValues {
        self.parameters_of(place)
    }

    pub(super) fn parameters_of(&self, place: &[f64]) -> ParameterValues {
        let mut parameters = Vec::new();
        self.parameters_into(place, &mut parameters);
        ParameterValues(parameters)
    }

    fn parameters_into(&self, place: &[f64], parameters: &mut Vec<f64>) {
        parameters.clone_from(&self.base.0);
        for (&index, &u) in self.free.iter().zip(place) {
            parameters[index] = self.machine.parameters[index].from_unit(u.clamp(0.0, 1.0));
        }
    }

    /// Returns the number of compared frequencies and amplitudes.
    pub fn observations(&self) -> usize {
        self.rows().iter().map(|rows| rows - 1).sum()
    }

    /// Whether the gain is unknown and the objective depends on it.
    pub fn estimates_gain(&self) -> bool {
        self.gain == Gain::Unknown
            && self.settings.objective != Objective::Frequencies
            && self.positions.iter().any(|p| p.observed.iter().any(|m| m.amplitude.is_some()))
    }

    /// Calls `work` with working memory.
    pub(super) fn with_scratch<T>(&self, work: impl FnOnce(&mut ModeScratch) -> T) -> T {
        let pooled = self.pool.lock().ok().and_then(|mut pool| pool.pop());
        let mut scratch = pooled.unwrap_or_else(|| ModeScratch {
            network: self.structure.empty_model(),
            work: self.structure.workspace(),
            parameters: Vec::new(),
            predictions: vec![PositionPrediction::default(); self.positions.len()],
            candidates: Vec::new(),
            least: Vec::new(),
            pairs: Vec::new(),
        });
        let result = work(&mut scratch);
        if let Ok(mut pool) = self.pool.lock() {
            pool.push(scratch);
        }
        result
    }

    /// Predicts all positions with the given parameters.
    pub fn predict(&self, parameters: &ParameterValues) -> Vec<PositionPrediction> {
        self.with_scratch(|scratch| {
            scratch.parameters.clear();
            scratch.parameters.extend(parameters);
            (0..self.positions.len()).for_each(|at| self.predict_one(at, scratch));
            scratch.predictions.clone()
        })
    }

    /// Predicts one position.
    pub(super) fn predict_one(&self, at: usize, scratch: &mut ModeScratch) {
        let p = &self.positions[at];
        let ModeScratch { network, work, parameters, predictions, candidates, least, pairs } = scratch;
        network.update(self.machine, parameters, &p.operating);
        let PositionPrediction { position, peaks, deviations } = &mut predictions[at];
        *position = p.index;
        peaks_into(network, (self.search, &p.lines), work, peaks);
        // The measuring chain changes the amplitude. The shift of the peak by the order of ζ² is neglected.
        let chain = self.machine.chain.at(parameters, &p.operating);
        peaks.iter_mut().for_each(|peak| {
            peak.amplitude *= Chain::log_factor(chain, omega_rad_s(peak.frequency_hz)).re.exp()
        });
        candidates.clear();
        candidates.extend(peaks.iter().map(|peak| self.candidate(peak)));
        pair_into(&p.sought, candidates, least, pairs);
        deviations.clear();
        let paired = |ModePair { measured, predicted }: &ModePair| Deviation {
            observed: measured.and_then(|i| p.observation[i]).map(|i| p.observed[i]),
            predicted: predicted.map(|i| peaks[i]),
            visibility: match (measured, predicted) {
                (None, Some(j)) => candidates[*j].visibility,
                (Some(i), Some(j)) if p.sought[*i].is_some() => candidates[*j].presence,
                _ => 0.0,
            },
        };
        deviations.extend(pairs.iter().map(paired).filter(|d| d.observed.is_some() || d.predicted.is_some()));
    }

    /// Judges a predicted peak by these measurements.
    pub(super) fn candidate(&self, peak: &Peak) -> PredictedPeak {
        PredictedPeak::new(peak.prominence, peak.frequency_hz, self.least_prominence, self.band_hz)
    }

    /// Returns the derivatives of [`ModeObjective::candidate`], as [`PredictedPeak::slopes`].
    pub(super) fn candidate_slopes(&self, peak: &Peak) -> [[f64; 2]; 2] {
        PredictedPeak::slopes(peak.prominence, peak.frequency_hz, self.least_prominence, self.band_hz)
    }

    /// Returns the weighted residual of a mode without a partner.
    pub(super) fn missing(&self) -> f64 {
        MISSING / self.settings.frequency_model_error.max(1e-6)
    }

    /// Computes the best gain for the predictions in the sense of the objective.
    pub fn amplitude_fit(&self, predictions: &[PositionPrediction]) -> AmplitudeFit {
        if self.settings.objective == Objective::Frequencies {
            return AmplitudeFit { gain: 1.0, count: 0 };
        }
        let ratios = predictions.iter().flat_map(|p| &p.deviations);
        let ratios =
            ratios.filter_map(|d| Some((d.observed?.amplitude?, d.predicted?.amplitude, d.visibility)));
        let (mut count, mut log_sum, mut present, mut sum, mut square) = (0, 0.0, 0.0, 0.0, 0.0);
        for (measured, predicted, share) in ratios {
            count += 1;
            log_sum += share * (measured / predicted).ln();
            present += share;
            sum += predicted / measured;
            square += (predicted / measured) * (predicted / measured);
        }
        let gain = match (self.gain, count, self.settings.objective) {
            (Gain::Known(gain), _, _) => gain,
            (Gain::Unknown, 0, _) => 1.0,
            (Gain::Unknown, _, Objective::Eq26) => sum / square,
            (Gain::Unknown, ..) if present == 0.0 => 1.0,
            (Gain::Unknown, ..) => (log_sum / present).exp(),
        };
        AmplitudeFit { gain, count }
    }

    /// Returns the weighted residuals in a fixed order: for each position frequencies, amplitudes, and one
    /// residual for modes that one side lacks.
    pub fn residuals(&self, predictions: &[PositionPrediction], gain: f64) -> Vec<f64> {
        let mut residuals = Vec::new();
        self.each_residual(predictions, gain, |residual| residuals.push(residual));
        residuals
    }

    fn each_residual(&self, predictions: &[PositionPrediction], gain: f64, mut each: impl FnMut(f64)) {
        for deviations in predictions.iter().map(|p| &p.deviations) {
            let observed =
                || deviations.iter().filter_map(|d| Some((d.observed?, d.predicted, d.visibility.sqrt())));
            for (observed, predicted, present) in observed() {
                each(predicted.map_or(0.0, |peak| {
                    let measured_hz = observed.frequency_hz.unwrap_or(peak.frequency_hz);
                    present * (peak.frequency_hz / measured_hz - 1.0)
                        / self.settings.frequency_sd(self.resolution_hz, measured_hz)
                }));
            }
            if self.settings.objective != Objective::Frequencies {
                for (amplitude, predicted, present) in
                    observed().filter_map(|(o, predicted, present)| Some((o.amplitude?, predicted, present)))
                {
                    each(predicted.map_or(0.0, |peak| {
                        present * (gain * peak.amplitude / amplitude).ln() / self.settings.amplitude_sd
                    }));
                }
            }
            each(self.missing() * f64::sqrt(deviations.iter().map(Deviation::lacking).sum()));
        }
    }

    /// Returns the deviations of free parameters from their priors, in prior standard deviations.
    fn prior_deviations<'p>(&'p self, parameters: &'p [f64]) -> impl Iterator<Item = f64> + 'p {
        let described = |i: &usize| &self.machine.parameters[*i];
        self.free.iter().filter_map(move |i| described(i).deviation(parameters[*i]))
    }

    /// Extends coordinates of the free parameters by the best coordinate of an unknown gain.
    pub fn extended(&self, place: &[f64]) -> Place {
        let mut extended = place.to_vec();
        if self.estimates_gain() {
            let gain = self.amplitude_fit(&self.predict(&self.parameters_of(place))).gain;
            extended.push(((gain / GAIN_RANGE.0).ln() / (GAIN_RANGE.1 / GAIN_RANGE.0).ln()).clamp(0.0, 1.0));
        }
        Place(extended)
    }

    /// Returns the gain at [`ModeObjective::extended`] coordinates.
    pub fn gain(&self, place: &Place) -> f64 {
        self.gain_of(place)
    }

    pub(super) fn gain_of(&self, place: &[f64]) -> f64 {
        match (self.gain, place.get(self.free.len())) {
            (Gain::Known(gain), _) => gain,
            (Gain::Unknown, Some(u)) => GAIN_RANGE.0 * (u * (GAIN_RANGE.1 / GAIN_RANGE.0).ln()).exp(),
            (Gain::Unknown, None) => 1.0,
        }
    }

    /// Returns all weighted residuals at [`ModeObjective::extended`] coordinates, with those of the priors
    /// last.
    pub fn residuals_at(&self, place: &Place) -> Vec<f64> {
        self.residuals_of(place)
    }

    /// As [`ModeObjective::residuals_at`] for a place of the optimiser.
    pub(super) fn residuals_of(&self, place: &[f64]) -> Vec<f64> {
        let parameters = self.parameters_of(place);
        self.with_priors(self.residuals(&self.predict(&parameters), self.gain_of(place)), &parameters)
    }

    /// Returns residuals of the data, made independent, and those of the priors after them.
    pub(super) fn with_priors(&self, mut residuals: Vec<f64>, parameters: &[f64]) -> Vec<f64> {
        if let Some(whitening) = &self.whitening {
            residuals = (whitening * DVector::from_vec(residuals)).data.into();
        }
        residuals.extend(self.prior_deviations(parameters));
        residuals
    }

    /// Returns the number of rows of each position in [`ModeObjective::residuals`].
    pub fn rows(&self) -> Vec<usize> {
        let counts_amplitudes = self.settings.objective != Objective::Frequencies;
        let amplitudes = |p: &PositionData| {
            p.observed.iter().filter(|m| counts_amplitudes && m.amplitude.is_some()).count()
        };
        self.positions.iter().map(|p| p.observed.len() + amplitudes(p) + 1).collect()
    }

    /// Whether the sum of squared residuals is a likelihood, so that intervals can be computed.
    pub fn is_likelihood(&self) -> bool {
        self.settings.objective != Objective::Eq26
    }

    /// Returns the objective at given coordinates, always finite. Above `limit` any value above it may be
    /// returned.
    pub fn cost_at(&self, place: &[f64], limit: f64) -> f64 {
        self.with_scratch(|scratch| {
            self.parameters_into(place, &mut scratch.parameters);
            self.cost_at_most(scratch, limit)
        })
    }

    /// Evaluates position by position and stops above the limit.
    ///
    /// With the gain at its best for the positions so far, a sum of squares can only rise with each further
    /// one. Eq. 26 has no such bound.
    fn cost_at_most(&self, scratch: &mut ModeScratch, limit: f64) -> f64 {
        let may_end = limit < f64::INFINITY && self.settings.objective != Objective::Eq26;
        let mut cost = 0.0;
        for at in 0..self.positions.len() {
            self.predict_one(at, scratch);
            if may_end || at + 1 == self.positions.len() {
                cost = self.cost_of(&scratch.predictions[..=at], &scratch.parameters);
            }
            if may_end && cost > limit * (1.0 + 1e-9) {
                break;
            }
        }
        cost
    }

    /// Returns the objective of predictions for some positions.
    fn cost_of(&self, predictions: &[PositionPrediction], parameters: &[f64]) -> f64 {
        let gain = self.amplitude_fit(predictions).gain;
        match self.settings.objective {
            Objective::LeastSquares | Objective::Frequencies => {
                let mut data = 0.0;
                self.each_residual(predictions, gain, |residual| data += residual * residual);
                data + self.prior_deviations(parameters).map(|r| r * r).sum::<f64>()
            }
            Objective::Eq26 => {
                let mut sum = 0.0;
                for deviation in predictions.iter().flat_map(|p| &p.deviations) {
                    sum += match (deviation.observed, deviation.pair()) {
                        (Some(observed), Some((_, peak))) => {
                            let frequency =
                                observed.frequency_hz.map_or(0.0, |f| peak.frequency_hz / f - 1.0);
                            let amplitude = observed
                                .amplitude
                                .map_or(0.0, |a| (gain * peak.amplitude / a - 1.0).clamp(-1e3, 1e3));
                            frequency * frequency + amplitude * amplitude
                        }
                        // Both terms of a mode that is not predicted are 1.
                        (Some(observed), None) => 1.0 + f64::from(u8::from(observed.amplitude.is_some())),
                        _ => 0.0,
                    };
                }
                f64::sqrt(sum)
            }
        }
    }
}
