//! Objectives on natural frequencies and amplitudes.

use nalgebra::DMatrix;
use std::sync::{Arc, Mutex};

use super::ObjectiveError;
use super::closed_loop::Excitation;
use super::mode_settings::{ModeSettings, Objective};
use super::pairing::{Deviation, ModePair, PredictedPeak, VISIBLE, pair_into};
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
    pub(super) observed: Vec<ModeObservation>,
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
    pub(super) gain: Gain,
    pub(super) resolution_hz: Option<f64>,
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
        let Some(rows) = columns.first().map(Vec::len) else { return self };
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
        let resolution_hz = table.resolution_hz;
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

    pub(super) fn parameters_into(&self, place: &[f64], parameters: &mut Vec<f64>) {
        parameters.clone_from(&self.base.0);
        for (&index, &u) in self.free.iter().zip(place) {
            parameters[index] = self.machine.parameters[index].from_unit(u.clamp(0.0, 1.0));
        }
    }

    /// Returns weights and options.
    pub(crate) fn mode_settings(&self) -> ModeSettings {
        self.settings
    }

    /// Returns the rounding step of the frequencies (Hz).
    pub(crate) fn resolution_hz(&self) -> Option<f64> {
        self.resolution_hz
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
}
