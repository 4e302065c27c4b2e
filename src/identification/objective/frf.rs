//! Objective on whole FRFs: the complex logarithm of measured over predicted, line by line.

use std::sync::{Arc, Mutex, OnceLock};

use num_complex::Complex64;
use rayon::prelude::*;

use super::record::{FrfRecord, Here, check_overlap, factor, log_factor, operating, record, wrapped};
use super::setup::{GAIN_RANGE, free_parameters, keep_rods, point_named};
use super::{FrfSettings, ObjectiveError};
use dynamics::model::{ABREAST, AssembledModel, Complexes, LANES, Reals, Structure, Workspace};
use machine::{FitRule, Machine};
use measurement::{FitSet, Gain, HoldOutSet, MeasurementSet};
use numeric::statistics::root_mean_square;

/// Most lines of one FRF in the coarse cost that the global search sees.
pub const COARSE_LINES: usize = 120;

/// The gap of one FRF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrfGap {
    /// Index of the FRF in the set.
    pub frf: usize,
    /// √ of the mean of ½·[(ln|H_m| − ln|H_s|)² + wrap(arg H_m − arg H_s)²].
    pub gap: f64,
    /// The gap that the noise of the lines alone leaves; `None` where nothing is known of it.
    pub noise_floor: Option<f64>,
    /// Lines compared.
    pub lines: usize,
}

/// Standard deviations of a nut position, or of a channel's gain or delay, from one end of its coordinate to the other.
pub(super) const SPAN: f64 = 20.0;

/// Room for one evaluation.
pub(super) struct FrfScratch {
    pub(super) network: AssembledModel,
    pub(super) work: Workspace,
    /// Derivatives of the receptances with the columns.
    pub(super) row: Vec<Complexes>,
}

/// Distance between predicted and measured FRFs, as a function of a machine's free parameters and, where it is unknown, the gain.
///
/// # Source  r = ln(H_measured/H_predicted): relative in magnitude, absolute in phase; variance of its components by Bendat and Piersol
/// from the coherence, see [`Frf::component_sd`](measurement::Frf::component_sd).
pub struct FrfObjective<'m> {
    pub(super) machine: &'m Machine,
    structures: Vec<Arc<Structure>>,
    /// Response and excitation (points) of each structure.
    pub(super) channels: Vec<(usize, usize)>,
    /// ln(gain) and delay (s) of each channel where no place states them.
    pub(super) calibration: Vec<(f64, f64)>,
    pub(super) settings: FrfSettings,
    pub(super) records: Vec<FrfRecord>,
    gain: Gain,
    /// Nut positions that are known only to a standard deviation.
    pub(super) nuts: usize,
    /// Indices of the parameters that are free, tolerances last.
    pub free: Vec<usize>,
    /// How many of them are no tolerances: those the global search varies.
    pub own: usize,
    base: Vec<f64>,
    pools: Vec<Mutex<Vec<FrfScratch>>>,
    /// Records of few lines, made when they are first asked for.
    few: OnceLock<Vec<FrfRecord>>,
}

impl<'m> FrfObjective<'m> {
    /// For the FRFs to be fitted; `frozen` parameters keep their start values.
    ///
    /// # Errors  there is no FRF to fit, one names points the machine lacks or lies outside the screw, two share no frequency.
    pub fn new(machine: &'m Machine, fit: &FitSet<'_>, settings: FrfSettings, frozen: &[String]) -> Result<Self, ObjectiveError> {
        if fit.frfs.is_empty() {
            let path = &fit.set.path;
            return Err(ObjectiveError::Data(format!("{path}: no FRF is among what is to be fitted; name other positions or records")));
        }
        let free = free_parameters(machine, frozen, |rule| rule != FitRule::Never)?;
        Self::over(machine, fit.set, &fit.frfs, settings, free)
    }

    /// For the FRFs held out: to predict, not to fit.
    ///
    /// # Errors  as [`FrfObjective::new`]; none of them shares a frequency with those fitted.
    pub fn held_out(machine: &'m Machine, held_out: &HoldOutSet<'_>, settings: FrfSettings) -> Result<Self, ObjectiveError> {
        Self::over(machine, held_out.set, &held_out.frfs, settings, Vec::new())
    }

    fn over(
        machine: &'m Machine,
        set: &MeasurementSet,
        frfs: &[usize],
        settings: FrfSettings,
        free: Vec<usize>,
    ) -> Result<Self, ObjectiveError> {
        let mut structures: Vec<Arc<Structure>> = Vec::new();
        let mut channels: Vec<(usize, usize)> = Vec::new();
        let mut records = Vec::new();
        let mut nuts_m: Vec<f64> = Vec::new();
        let mut groups: Vec<(Option<usize>, Option<&String>)> = Vec::new();
        for &index in frfs {
            let frf = &set.frfs[index];
            let response = point_named(machine, &frf.source, "response", &frf.response)?;
            let excitation = point_named(machine, &frf.source, "excitation", &frf.excitation)?;
            let operating = operating(set, frf);
            machine.check_operating(&frf.source, &operating)?;
            let structure = match channels.iter().position(|c| *c == (response, excitation)) {
                Some(at) => at,
                None => {
                    structures.push(Arc::new(Structure::new(machine, response, excitation, settings.rods)?));
                    channels.push((response, excitation));
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
            records.push(FrfRecord { nut, group, ..record(frf, index, operating, structure, settings)? });
        }
        check_overlap(set, &records)?;
        let pools = structures.iter().map(|_| Mutex::new(Vec::new())).collect();
        let nuts = if settings.nut_sd_m > 0.0 { nuts_m.len() } else { 0 };
        let (base, few) = (machine.start(), OnceLock::new());
        let own = free.iter().filter(|i| !machine.parameters[**i].is_tolerance()).count();
        let calibration = vec![(0.0, 0.0); channels.len()];
        let (records_yet, gain) = (Vec::new(), set.gain);
        let empty = FrfObjective {
            machine,
            structures,
            channels,
            calibration,
            settings,
            records: records_yet,
            gain,
            nuts,
            free,
            own,
            base,
            pools,
            few,
        };
        Ok(FrfObjective { records: empty.laid(records), ..empty })
    }

    /// Records with the entries of those rods kept that neither free parameters nor nut positions change.
    fn laid(&self, mut records: Vec<FrfRecord>) -> Vec<FrfRecord> {
        let place = |u: f64| self.here(&vec![u; self.free.len() + 1 + self.nuts + 2 * self.free_channels()]);
        let places = [0.3, 0.7].map(place);
        for record in &mut records {
            let at = places.each_ref().map(|here| (here.parameters.as_slice(), here.operating(record)));
            keep_rods(Arc::make_mut(&mut record.lines), (self.machine, &self.structures[record.structure]), at);
        }
        records
    }

    /// The FRFs compared.
    pub fn records(&self) -> &[FrfRecord] {
        &self.records
    }

    /// The machine whose parameters are free.
    pub fn machine(&self) -> &Machine {
        self.machine
    }

    /// Whether the gain is estimated along.
    pub fn estimates_gain(&self) -> bool {
        self.gain == Gain::Unknown
    }

    /// Real numbers compared: two for each line.
    pub fn observations(&self) -> usize {
        2 * self.records.iter().map(|r| r.omega_rad_s.len()).sum::<usize>()
    }

    /// Parameters of the machine, in its order, for a place of the free ones in the unit cube.
    pub fn parameters(&self, place: &[f64]) -> Vec<f64> {
        let mut parameters = self.base.clone();
        for (&index, &u) in self.free.iter().zip(place) {
            parameters[index] = self.machine.parameters[index].from_unit(u.clamp(0.0, 1.0));
        }
        parameters
    }

    /// ln of the gain at a place: of the set where it is known, else that of the place's last coordinate.
    fn log_gain(&self, place: &[f64]) -> f64 {
        match self.gain {
            Gain::Known(gain) => gain.ln(),
            Gain::Unknown => {
                let u = place.get(self.free.len()).copied().unwrap_or(0.5);
                GAIN_RANGE.0.ln() + u * (GAIN_RANGE.1 / GAIN_RANGE.0).ln()
            }
        }
    }

    /// What a place means; coordinates beyond the free parameters may be absent.
    pub(super) fn here(&self, place: &[f64]) -> Here {
        let first = self.free.len() + usize::from(self.estimates_gain());
        let span = |at: usize, sd: f64| place.get(first + at).map_or(0.0, |u| (u - 0.5) * SPAN * sd);
        let nut = |at: usize| span(at, self.settings.nut_sd_m);
        let channel = |index: usize| {
            let at = self.nuts + 2 * index;
            match place.len() > first + at && self.free_channels() > 0 {
                true => (span(at, self.settings.channel_sd.0), span(at + 1, self.settings.channel_sd.1)),
                false => self.calibration[index],
            }
        };
        Here {
            parameters: self.parameters(place),
            log_gain: self.log_gain(place),
            nut_shift_m: (0..self.nuts).map(nut).collect(),
            channels: (0..self.channels.len()).map(channel).collect(),
        }
    }

    /// Coordinates of nut positions in a place that was [`FrfObjective::extended`].
    pub fn nut_coordinates(&self) -> std::ops::Range<usize> {
        let first = self.free.len() + usize::from(self.estimates_gain());
        first..first + self.nuts
    }

    /// Channels whose gain and delay are fitted along.
    pub(super) fn free_channels(&self) -> usize {
        if self.settings.channel_sd.0.max(self.settings.channel_sd.1) > 0.0 { self.structures.len() } else { 0 }
    }

    pub(super) fn borrow(&self, structure: usize) -> FrfScratch {
        let pooled = self.pools[structure].lock().ok().and_then(|mut pool| pool.pop());
        pooled.unwrap_or_else(|| FrfScratch {
            network: self.structures[structure].network(),
            work: self.structures[structure].workspace(),
            row: Vec::new(),
        })
    }

    pub(super) fn give_back(&self, structure: usize, scratch: FrfScratch) {
        if let Ok(mut pool) = self.pools[structure].lock() {
            pool.push(scratch);
        }
    }

    /// Calls `each(line, residuals)` for every four lines of a record from a multiple of four on, with r = ln(measured/predicted) before the set's gain is
    /// taken off; past the last line, those of the last.
    pub(super) fn visit(&self, record: &FrfRecord, here: &Here, lines: std::ops::Range<usize>, mut each: impl FnMut(usize, Complexes)) {
        let operating = here.operating(record);
        let mut scratch = self.borrow(record.structure);
        scratch.network.update(self.machine, &here.parameters, &operating);
        let factor = factor(self.machine.chain.at(&here.parameters, &operating), here.channel(record));
        let groups = lines.start / LANES..lines.end.div_ceil(LANES);
        for from in groups.clone().step_by(ABREAST) {
            let some = from..groups.end.min(from + ABREAST);
            let predicted = scratch.network.receptances_on(&record.lines, some.clone(), &mut scratch.work);
            for ((at, predicted), omega) in some.clone().zip(predicted).zip(&record.lines.omega_rad_s()[some]) {
                let residual = record.measured(at * LANES) - predicted.ln() - log_factor(factor, *omega);
                each(at * LANES, wrapped(residual));
            }
        }
        self.give_back(record.structure, scratch);
    }

    /// Residuals of all records at these parameters and gain, nut positions as they are stated.
    pub fn residuals(&self, parameters: &[f64], gain: f64) -> Vec<Vec<Complex64>> {
        self.residuals_here(&self.as_stated(parameters, gain))
    }

    fn as_stated(&self, parameters: &[f64], gain: f64) -> Here {
        let (parameters, channels) = (parameters.to_vec(), self.calibration.clone());
        Here { parameters, log_gain: gain.ln(), nut_shift_m: Vec::new(), channels }
    }

    /// Residuals of all records at a place of the free parameters, gain, nut positions and channels.
    pub fn residuals_at(&self, place: &[f64]) -> Vec<Vec<Complex64>> {
        self.residuals_here(&self.here(place))
    }

    /// The same lines and weights with every residual at a place changed by what is given: data another machine would have made.
    #[must_use]
    pub fn shifted(&self, by: &[Vec<Complex64>]) -> FrfObjective<'m> {
        let mut other = self.resampled(&[]);
        for (record, by) in other.records.iter_mut().zip(by) {
            record.log_measured.iter_mut().zip(by).for_each(|(h, by)| *h += by);
        }
        other
    }

    fn residuals_here(&self, here: &Here) -> Vec<Vec<Complex64>> {
        self.records
            .par_iter()
            .map(|record| {
                let mut residuals = Vec::with_capacity(record.omega_rad_s.len());
                let count = record.omega_rad_s.len();
                self.visit(record, here, 0..count, |line, r| {
                    residuals.extend(r.apart().iter().take(count - line).map(|r| r - here.log_gain));
                });
                residuals
            })
            .collect()
    }

    /// Gap of each record at these parameters and gain.
    ///
    /// # Source  the gap between a measured and a predicted FRF as this project defines it: root mean square of ln H, per component.
    pub fn gaps(&self, parameters: &[f64], gain: f64) -> Vec<FrfGap> {
        self.gaps_of(self.residuals(parameters, gain))
    }

    /// Gap of each record at a place, with what is fitted along.
    pub fn gaps_at(&self, place: &[f64]) -> Vec<FrfGap> {
        self.gaps_of(self.residuals_at(place))
    }

    fn gaps_of(&self, residuals: Vec<Vec<Complex64>>) -> Vec<FrfGap> {
        self.records
            .iter()
            .zip(residuals)
            .map(|(record, residuals)| {
                let noise: Option<Vec<f64>> = record.stated_sd.iter().copied().collect();
                FrfGap {
                    frf: record.frf,
                    gap: (residuals.iter().map(|r| 0.5 * r.norm_sqr()).sum::<f64>() / residuals.len() as f64).sqrt(),
                    noise_floor: noise.and_then(root_mean_square),
                    lines: residuals.len(),
                }
            })
            .collect()
    }

    /// Mean of ½·|r|² over some lines of every record, the gain (where unknown) at its best: the cost of the global search, whose valleys are
    /// wide because no line weighs more than another.
    pub fn coarse(&self, place: &[f64]) -> f64 {
        let here = self.here(place);
        let (mut lines, mut sum, mut square) = (0, Reals::ZERO, Reals::ZERO);
        for record in self.few.get_or_init(|| self.laid(self.records.iter().map(|r| r.thinned(COARSE_LINES)).collect())) {
            let count = record.omega_rad_s.len();
            lines += count;
            self.visit(record, &here, 0..count, |line, r| {
                let counted = Reals::from(std::array::from_fn::<_, LANES, _>(|lane| f64::from(u8::from(line + lane < count))));
                sum += r.re * counted;
                square += r.norm_sqr() * counted;
            });
        }
        let (count, sum, square) = (lines as f64, sum.reduce_add(), square.reduce_add());
        let gain = match self.gain {
            Gain::Known(gain) => gain.ln(),
            Gain::Unknown => sum / count,
        };
        let gap = 0.5 * (square / count - 2.0 * gain * sum / count + gain * gain);
        let cost =
            gap + 0.5 * self.known(&here).map(|k| k.deviation * k.deviation).sum::<f64>() * self.settings.model_error.powi(2) / count;
        if cost.is_finite() { cost } else { f64::MAX }
    }

    /// The gain of the set, or where it is unknown the one that suits these parameters best.
    pub fn best_gain(&self, parameters: &[f64]) -> f64 {
        if let Gain::Known(gain) = self.gain {
            return gain;
        }
        let here = self.as_stated(parameters, 1.0);
        let (mut weights, mut sum) = (Reals::ZERO, Reals::ZERO);
        for record in &self.records {
            self.visit(record, &here, 0..record.omega_rad_s.len(), |line, r| {
                weights += record.weights(line);
                sum += record.weights(line) * r.re;
            });
        }
        f64::exp(sum.reduce_add() / weights.reduce_add())
    }

    /// A place of the free parameters, or of those that are no tolerances, with the others as stated and the best coordinate of the gain added where that is
    /// unknown.
    pub fn extended(&self, place: &[f64]) -> Vec<f64> {
        let mut extended = place.to_vec();
        let stated = |i: &usize| self.machine.parameters[*i].to_unit(self.machine.parameters[*i].start);
        extended.extend(self.free.iter().skip(place.len()).map(stated));
        if self.estimates_gain() {
            let gain = self.best_gain(&self.parameters(place));
            extended.push(((gain / GAIN_RANGE.0).ln() / (GAIN_RANGE.1 / GAIN_RANGE.0).ln()).clamp(0.0, 1.0));
        }
        extended.extend(vec![0.5; self.nuts + 2 * self.free_channels()]);
        extended
    }

    /// The gain at a place that was [`FrfObjective::extended`].
    pub fn gain(&self, place: &[f64]) -> f64 {
        self.log_gain(place).exp()
    }

    /// By how much the correlation of neighbouring lines enlarges the variance of what is fitted, 1 + 2·Σρ over the lags up to the first that is
    /// not significant: 1 for noise alone, many where the model's own error is fitted.
    ///
    /// # Source  effective sample size of an autocorrelated series; Bayley and Hammersley, J. R. Stat. Soc. Suppl. 8 (1946) 184–197.
    pub fn colour(&self, place: &[f64]) -> f64 {
        let residuals = self.residuals_here(&self.here(place));
        let weighted =
            |record: &FrfRecord, r: &[Complex64]| -> Vec<Complex64> { r.iter().zip(&record.weight).map(|(r, w)| r * w.sqrt()).collect() };
        let series: Vec<Vec<Complex64>> = self.records.iter().zip(&residuals).map(|(record, r)| weighted(record, r)).collect();
        let total: f64 = series.iter().flatten().map(Complex64::norm_sqr).sum();
        let count = 2.0 * series.iter().map(Vec::len).sum::<usize>() as f64;
        let longest = series.iter().map(Vec::len).max().unwrap_or(0) / 10;
        let mut sum = 0.0;
        for lag in 1..=longest {
            let products: f64 = series.iter().flat_map(|s| s.iter().zip(s.iter().skip(lag))).map(|(a, b)| (a * b.conj()).re).sum();
            let correlation = products / total;
            if !(correlation > 2.0 / count.sqrt()) {
                break;
            }
            sum += correlation;
        }
        1.0 + 2.0 * sum
    }

    /// The same data with the lines of each record counted `counts[record][line]` times, once where nothing is given: a bootstrap sample.
    #[must_use]
    pub fn resampled(&self, counts: &[Vec<f64>]) -> FrfObjective<'m> {
        let mut records = self.records.clone();
        for (record, counts) in records.iter_mut().zip(counts) {
            record.weight.iter_mut().zip(counts).for_each(|(w, c)| *w *= c);
        }
        let pools = self.structures.iter().map(|_| Mutex::new(Vec::new())).collect();
        let (structures, channels, calibration) = (self.structures.clone(), self.channels.clone(), self.calibration.clone());
        let (free, base) = (self.free.clone(), self.base.clone());
        FrfObjective { structures, channels, calibration, records, free, base, pools, few: OnceLock::new(), ..*self }
    }

    /// The same data with at most so many lines of each record.
    #[must_use]
    pub fn thinned(&self, most: usize) -> FrfObjective<'m> {
        self.with_records(|record| record.thinned(most))
    }

    /// The same with at most `most` lines of each record, closest where its curve turns and weighed by how many they stand for: to look around, since their
    /// χ² has more scatter than its weights say.
    #[must_use]
    pub fn curvature_sampled(&self, most: usize) -> FrfObjective<'m> {
        self.with_records(|record| record.curvature_sampled(most))
    }

    fn with_records(&self, each: impl Fn(&FrfRecord) -> FrfRecord) -> FrfObjective<'m> {
        let mut other = self.resampled(&[]);
        other.records = self.laid(self.records.iter().map(each).collect());
        other
    }

    /// χ² that the noise of the lines alone leaves, per number compared.
    pub fn noise_share(&self) -> f64 {
        let share = |r: &FrfRecord| r.noise_sd.iter().zip(&r.weight).map(|(sd, weight)| sd.unwrap_or(0.0).powi(2) * weight).sum::<f64>();
        self.records.iter().map(share).sum::<f64>() / self.lines().iter().sum::<usize>().max(1) as f64
    }

    /// Lines of each record, and the group it belongs to: the FRFs of one position, or of one record where there is no position.
    pub fn blocks(&self) -> Vec<(usize, usize)> {
        self.records.iter().map(|r| (r.omega_rad_s.len(), r.group)).collect()
    }

    /// Lines of each record.
    pub fn lines(&self) -> Vec<usize> {
        self.records.iter().map(|r| r.omega_rad_s.len()).collect()
    }
}
