//! Objective on whole FRFs: the complex logarithm of measured over predicted receptance, line by line.

use std::sync::{Arc, Mutex, OnceLock};

use num_complex::Complex64;

use super::closed_loop::{ClosedLoop, EncoderScratch, Evaluation, Excitation, Loops, loop_parameters};
use super::record::{Decoded, FrfRecord, check_overlap, operating, record};
use super::setup::{GAIN_RANGE, free_parameters, keep_rods, point_named};
use super::{FrfSettings, ObjectiveError};
use crate::Place;
use dynamics::model::{AssembledModel, Complexes, Structure, Workspace};
use machine::{FitRule, Machine, Operating, ParameterValues};
use measurement::{FitSet, Gain, HoldOutSet, MeasurementSet};

/// Width of the unit interval of a nut position, or of a channel's gain or delay, in prior standard
/// deviations (1).
pub(super) const SPAN: f64 = 20.0;

/// Working memory of one evaluation.
pub(super) struct FrfScratch {
    pub(super) network: AssembledModel,
    pub(super) work: Workspace,
    /// Derivatives of the receptances with respect to the columns.
    pub(super) row: Vec<Complexes>,
    /// The receptances of the encoders of a closed loop; empty for FRFs of force.
    pub(super) encoders: Vec<EncoderScratch>,
}

/// A pair of response and excitation.
#[derive(Clone)]
pub(super) struct FrfChannel {
    /// Response (point) and excitation.
    pub(super) points: (usize, Excitation),
    structure: Arc<Structure>,
    /// The closed loop, where the excitation is the command.
    closed: Option<Arc<ClosedLoop>>,
    /// ln(gain) and delay (s), where they are not coordinates.
    pub(super) calibration: (f64, f64),
    pool: Arc<Mutex<Vec<FrfScratch>>>,
}

/// Misfit between predicted and measured FRFs as a function of free parameters, an unknown gain and nuisance
/// parameters.
///
/// # Source  r = ln(H_measured/H_predicted): relative in magnitude, absolute in phase; variance of its
///   components by Bendat and Piersol
/// from the coherence, see [`Frf::component_sd`](measurement::Frf::component_sd).
pub struct FrfObjective<'m> {
    pub(super) machine: &'m Machine,
    pub(super) channels: Vec<FrfChannel>,
    /// Whether the drive, and so a closed-loop FRF, depends on each parameter.
    pub(super) of_drive: Vec<bool>,
    pub(super) settings: FrfSettings,
    pub(super) records: Vec<FrfRecord>,
    pub(super) gain: Gain,
    /// Number of nut positions with a tolerance.
    pub(super) nuts: usize,
    /// Indices of the free parameters, tolerances last.
    pub free: Vec<usize>,
    /// Number of free parameters that are not tolerances: those the global search varies.
    pub own_count: usize,
    pub(super) base: ParameterValues,
    /// The objectives of a global search: on thinned lines, and on these with equal weights and tolerances
    /// held.
    pub(super) thin: OnceLock<Box<FrfObjective<'m>>>,
    pub(super) coarse: OnceLock<Box<FrfObjective<'m>>>,
}

impl<'m> FrfObjective<'m> {
    /// Builds the objective of the FRFs to fit; `frozen` parameters keep their start values.
    ///
    /// # Errors  there is no FRF to fit; one names points that the machine lacks, or lies outside the screw;
    ///   two do not overlap in frequency.
    pub fn new(
        machine: &'m Machine,
        fit: &FitSet<'_>,
        settings: FrfSettings,
        frozen: &[String],
    ) -> Result<Self, ObjectiveError> {
        if fit.frfs().is_empty() {
            let path = &fit.set().path;
            return Err(ObjectiveError::Data(format!(
                "{path}: the selection to fit contains no FRF; name other positions or records"
            )));
        }
        Self::for_frfs(machine, (fit.set(), fit.frfs()), settings, Some(frozen))
    }

    /// As [`FrfObjective::new`] for held-out FRFs: for their likelihood with a fit to other data, or for
    /// simulated records, with which
    /// [`FrfObjective::shifted`] replaces them. They enter no fit.
    ///
    /// # Errors  as [`FrfObjective::new`].
    pub fn for_held_out(
        machine: &'m Machine,
        held_out: &HoldOutSet<'_>,
        settings: FrfSettings,
        frozen: &[String],
    ) -> Result<Self, ObjectiveError> {
        if held_out.frfs().is_empty() {
            return Err(ObjectiveError::Data(format!("{}: no FRF is held out", held_out.set().path)));
        }
        Self::for_frfs(machine, (held_out.set(), held_out.frfs()), settings, Some(frozen))
    }

    /// Builds the objective of the held-out FRFs, to predict them.
    ///
    /// # Errors  as [`FrfObjective::new`], except that no FRF is needed.
    pub fn held_out(
        machine: &'m Machine,
        held_out: &HoldOutSet<'_>,
        settings: FrfSettings,
    ) -> Result<Self, ObjectiveError> {
        Self::for_frfs(machine, (held_out.set(), held_out.frfs()), settings, None)
    }

    /// Without parameters to freeze none is free.
    fn for_frfs(
        machine: &'m Machine,
        (set, frfs): (&MeasurementSet, &[usize]),
        settings: FrfSettings,
        frozen: Option<&[String]>,
    ) -> Result<Self, ObjectiveError> {
        let of_drive = loop_parameters(machine, set, frfs);
        let free =
            frozen.map(|frozen| free_parameters(machine, frozen, &of_drive, |rule| rule != FitRule::Never));
        let mut free = free.transpose()?.unwrap_or_default();
        // The parameters of an effect that was added after the tolerances are searched like all others.
        free.sort_by_key(|index| machine.parameters[*index].is_tolerance());
        let mut channels: Vec<FrfChannel> = Vec::new();
        let mut records = Vec::new();
        let mut nuts_m: Vec<f64> = Vec::new();
        let mut groups: Vec<(Option<usize>, Option<&String>)> = Vec::new();
        for &index in frfs {
            let frf = &set.frfs[index];
            let response = point_named(machine, &frf.source, "response", &frf.response)?;
            let excitation = Excitation::named(machine, &frf.source, &frf.excitation)?;
            let operating = operating(set, frf);
            machine.check_operating(&frf.source, &operating)?;
            let structure = match channels.iter().position(|c| c.points == (response, excitation)) {
                Some(at) => at,
                None => {
                    let (structure, closed) =
                        excitation.structure(machine, &frf.source, response, settings.rods)?;
                    channels.push(FrfChannel {
                        points: (response, excitation),
                        structure: Arc::new(structure),
                        closed: closed.map(Arc::new),
                        calibration: (0.0, 0.0),
                        pool: Arc::default(),
                    });
                    channels.len() - 1
                }
            };
            let nut = match operating.nut_m {
                None => usize::MAX,
                Some(nut_m) => nuts_m.iter().position(|n| *n == nut_m).unwrap_or_else(|| {
                    nuts_m.push(nut_m);
                    nuts_m.len() - 1
                }),
            };
            let key = (frf.position, if frf.position.is_some() { None } else { frf.record.as_ref() });
            let group = groups.iter().position(|g| *g == key).unwrap_or_else(|| {
                groups.push(key);
                groups.len() - 1
            });
            let record = FrfRecord { nut, group, ..record(frf, index, operating, structure, settings)? };
            if excitation == Excitation::Command {
                if operating.window_per_s != 0.0 {
                    let fault = "states an exponential window, which suits the decay after a blow, not the response to a command; write exponential_window_s = 0 in its [[frf]]";
                    return Err(ObjectiveError::Data(format!("{}: {fault}", frf.source)));
                }
                ClosedLoop::check(
                    machine,
                    &frf.source,
                    record.frequencies_hz().last().copied().unwrap_or(0.0),
                )?;
            }
            records.push(record);
        }
        check_overlap(set, &records)?;
        let nuts = if settings.nut_sd_m > 0.0 { nuts_m.len() } else { 0 };
        let own_count = free.iter().filter(|i| !machine.parameters[**i].is_tolerance()).count();
        let empty = FrfObjective {
            machine,
            channels,
            of_drive: machine.closed_loop_parameters(),
            settings,
            records: Vec::new(),
            gain: set.gain,
            nuts,
            free,
            own_count,
            base: machine.start(),
            thin: OnceLock::new(),
            coarse: OnceLock::new(),
        };
        Ok(FrfObjective { records: empty.with_precomputed_rods(records), ..empty })
    }

    /// Precomputes the rods of records that neither free parameters nor nut positions change.
    pub(super) fn with_precomputed_rods(&self, mut records: Vec<FrfRecord>) -> Vec<FrfRecord> {
        let decoded =
            |u: f64| self.decode(&vec![u; self.free.len() + 1 + self.nuts + 2 * self.free_channels()]);
        let cases = [0.3, 0.7].map(decoded);
        for at in 0..records.len() {
            let (before, here) = records.split_at_mut(at);
            let record = &mut here[0];
            // Channels of one position have the same rods.
            let same = |other: &&FrfRecord| {
                other.group == record.group
                    && other.nut == record.nut
                    && other.omega_rad_s == record.omega_rad_s
            };
            if let Some(other) = before.iter().find(same) {
                record.lines = Arc::clone(&other.lines);
                continue;
            }
            let places = cases.each_ref().map(|here| (&here.parameters[..], here.operating(record)));
            keep_rods(
                Arc::make_mut(&mut record.lines),
                (self.machine, &self.channels[record.structure].structure),
                places,
            );
        }
        records
    }

    /// Returns the compared FRFs.
    pub fn records(&self) -> &[FrfRecord] {
        &self.records
    }

    /// Returns the machine whose parameters are free.
    pub fn machine(&self) -> &Machine {
        self.machine
    }

    /// Whether the gain is unknown and therefore estimated.
    pub fn estimates_gain(&self) -> bool {
        self.gain == Gain::Unknown
    }

    /// Returns the number of real numbers compared: two per line.
    pub fn observations(&self) -> usize {
        2 * self.records.iter().map(|r| r.omega_rad_s.len()).sum::<usize>()
    }

    /// Returns the machine's parameters, in its order, for unit-cube coordinates of the free ones.
    pub fn parameters(&self, place: &Place) -> ParameterValues {
        self.parameters_of(place)
    }

    fn parameters_of(&self, place: &[f64]) -> ParameterValues {
        let mut parameters = self.base.clone();
        for (&index, &u) in self.free.iter().zip(place) {
            parameters[index] = self.machine.parameters[index].from_unit(u.clamp(0.0, 1.0));
        }
        parameters
    }

    /// Returns ln of the gain at given coordinates: that of the set if it is known, otherwise that of its
    /// coordinate.
    pub(super) fn log_gain(&self, place: &[f64]) -> f64 {
        match self.gain {
            Gain::Known(gain) => gain.ln(),
            Gain::Unknown => {
                let u = place.get(self.free.len()).copied().unwrap_or(0.5);
                GAIN_RANGE.0.ln() + u * (GAIN_RANGE.1 / GAIN_RANGE.0).ln()
            }
        }
    }

    /// Converts unit-cube coordinates to physical values; coordinates after the free parameters may be
    /// absent.
    pub(super) fn decode(&self, place: &[f64]) -> Decoded {
        let first = self.free.len() + usize::from(self.estimates_gain());
        let span = |at: usize, sd: f64| place.get(first + at).map_or(0.0, |u| (u - 0.5) * SPAN * sd);
        let nut = |at: usize| span(at, self.settings.nut_sd_m);
        let channel = |index: usize| {
            let at = self.nuts + 2 * index;
            match place.len() > first + at && self.free_channels() > 0 {
                true => (span(at, self.settings.channel_sd.0), span(at + 1, self.settings.channel_sd.1)),
                false => self.channels[index].calibration,
            }
        };
        Decoded {
            parameters: self.parameters_of(place),
            log_gain: self.log_gain(place),
            nut_shift_m: (0..self.nuts).map(nut).collect(),
            channels: (0..self.channels.len()).map(channel).collect(),
        }
    }

    /// Returns the range of nut positions among [`FrfObjective::extended`] coordinates.
    pub fn nut_coordinates(&self) -> std::ops::Range<usize> {
        let first = self.free.len() + usize::from(self.estimates_gain());
        first..first + self.nuts
    }

    /// Returns the number of channels with fitted gain and delay.
    pub(super) fn free_channels(&self) -> usize {
        if self.settings.channel_sd.0.max(self.settings.channel_sd.1) > 0.0 { self.channels.len() } else { 0 }
    }

    /// Returns the loops of a channel at given values; `None` for an FRF of force.
    pub(super) fn loops(
        &self,
        channel: usize,
        (here, operating): (&Decoded, Operating),
        encoders: &mut [EncoderScratch],
        columns: &[Option<usize>],
    ) -> Option<Loops<'_>> {
        let at = Evaluation {
            machine: self.machine,
            of_drive: &self.of_drive,
            values: &here.parameters,
            operating,
        };
        Loops::new(self.channels[channel].closed.as_deref(), &at, encoders, columns)
    }

    pub(super) fn borrow(&self, channel: usize) -> FrfScratch {
        let FrfChannel { structure, closed, pool, .. } = &self.channels[channel];
        let pooled = pool.lock().ok().and_then(|mut pool| pool.pop());
        pooled.unwrap_or_else(|| FrfScratch {
            network: structure.empty_model(),
            work: structure.workspace(),
            row: Vec::new(),
            encoders: closed.as_ref().map(|closed| closed.scratch()).unwrap_or_default(),
        })
    }

    pub(super) fn give_back(&self, channel: usize, scratch: FrfScratch) {
        if let Ok(mut pool) = self.channels[channel].pool.lock() {
            pool.push(scratch);
        }
    }

    /// Returns the objective with shifted residuals and the same lines and weights: the data of a different
    /// machine.
    #[must_use]
    pub fn shifted(&self, by: &[Vec<Complex64>]) -> FrfObjective<'m> {
        let mut other = self.resampled(&[]);
        for (record, by) in other.records.iter_mut().zip(by) {
            record.log_measured.iter_mut().zip(by).for_each(|(h, by)| *h += by);
        }
        other
    }

    /// Extends coordinates of the free parameters, with or without tolerances, to all coordinates.
    ///
    /// Missing tolerances, nut positions and channels are as stated; an unknown gain has its best value.
    pub fn extended(&self, place: &[f64]) -> Place {
        let mut extended = place.to_vec();
        let stated =
            |i: &usize| self.machine.parameters[*i].to_unit(self.machine.parameters[*i].search_start());
        extended.extend(self.free.iter().skip(place.len()).map(stated));
        if self.estimates_gain() {
            let gain = self.best_gain(&self.parameters_of(place));
            extended.push(((gain / GAIN_RANGE.0).ln() / (GAIN_RANGE.1 / GAIN_RANGE.0).ln()).clamp(0.0, 1.0));
        }
        extended.extend(vec![0.5; self.nuts + 2 * self.free_channels()]);
        Place(extended)
    }

    /// Returns a bootstrap sample: the lines of each record count `counts[record][line]` times, or once where
    /// no count is given.
    #[must_use]
    pub fn resampled(&self, counts: &[Vec<f64>]) -> FrfObjective<'m> {
        let mut records = self.records.clone();
        for (record, counts) in records.iter_mut().zip(counts) {
            record.weight.iter_mut().zip(counts).for_each(|(w, c)| *w *= c);
        }
        FrfObjective {
            channels: self.channels.clone(),
            of_drive: self.of_drive.clone(),
            records,
            free: self.free.clone(),
            base: self.base.clone(),
            thin: OnceLock::new(),
            coarse: OnceLock::new(),
            ..*self
        }
    }

    /// Returns the number of lines of each record, and its group: the FRFs of one position, or of one record
    /// without a position.
    pub fn blocks(&self) -> Vec<(usize, usize)> {
        self.records.iter().map(|r| (r.omega_rad_s.len(), r.group)).collect()
    }

    /// Returns the number of lines of each record.
    pub fn lines(&self) -> Vec<usize> {
        self.records.iter().map(|r| r.omega_rad_s.len()).collect()
    }
}
