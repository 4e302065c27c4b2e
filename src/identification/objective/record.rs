//! FRFs prepared for comparison: log-receptances, weights and noise of their lines.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use num_complex::Complex64;

use super::{FrfSettings, ObjectiveError};
use dynamics::model::{Complexes, FrequencyGrid, LANES, Reals};
use machine::{Operating, ParameterValues};
use measurement::{Frf, FrfLine, MeasurementSet};
use numeric::statistics::median;
use numeric::unit::{frequency_hz, omega_rad_s};

/// Number of lines summed in one piece. Pieces are added in order, so that sums do not depend on the number
/// of threads.
const PIECE: usize = 256;

/// One FRF prepared for comparison.
#[derive(Debug, Clone)]
pub struct FrfRecord {
    /// Index of the FRF in the set.
    pub frf: usize,
    pub(super) operating: Operating,
    /// Index of the nut position in the objective; `usize::MAX` for none.
    pub(super) nut: usize,
    /// Index of the position (or record) in the objective.
    pub(super) group: usize,
    pub(super) structure: usize,
    pub(super) omega_rad_s: Vec<f64>,
    /// The same frequencies, with precomputed terms of the model.
    pub(super) lines: Arc<FrequencyGrid>,
    /// ln of the measured receptance.
    pub(super) log_measured: Vec<Complex64>,
    /// 1/s² of one component of ln H, with s by noise and model error.
    pub(super) weight: Vec<f64>,
    /// s by noise alone, where known, estimated from all lines together.
    pub(super) noise_sd: Vec<Option<f64>>,
    /// s by noise alone as each line states it, for the noise floor of the gap.
    pub(super) stated_sd: Vec<Option<f64>>,
}

impl FrfRecord {
    /// Returns the standard deviation of one component of ln H by noise alone, line by line, where known.
    pub fn noise(&self) -> &[Option<f64>] {
        &self.noise_sd
    }

    /// Returns the standard deviation of one component of ln H as a line states it, line by line, where
    /// known; [`FrfRecord::noise`] is averaged over neighbouring lines.
    pub fn stated_noise(&self) -> &[Option<f64>] {
        &self.stated_sd
    }

    /// Returns the record with every n-th line, at most `most`, and without precomputed rods.
    pub(super) fn thinned(&self, most: usize) -> FrfRecord {
        let stride = self.omega_rad_s.len().div_ceil(most.max(1)).max(1);
        self.with((0..self.omega_rad_s.len()).step_by(stride).collect())
    }

    /// Returns the record with at most `most` lines, dense where the curve bends and nowhere far apart.
    ///
    /// A narrow resonance between two evenly spaced lines remains visible. The density follows three measures
    /// in equal parts: number of lines, logarithm of the frequency, and length of the curve ln H in units of
    /// its noise. Each line is weighted by the number of lines it represents.
    pub(super) fn curvature_sampled(&self, most: usize) -> FrfRecord {
        let count = self.omega_rad_s.len();
        if count <= most.max(2) {
            return self.clone();
        }
        let arc_length = |at: usize| {
            let change = self.log_measured[at] - self.log_measured[at - 1];
            let phase = (change.im + PI).rem_euclid(TAU) - PI;
            change.re.hypot(phase) * self.weight[at].min(self.weight[at - 1]).sqrt()
        };
        let measures = [
            vec![1.0; count - 1],
            (1..count).map(|at| (self.omega_rad_s[at] / self.omega_rad_s[at - 1]).ln()).collect(),
            (1..count).map(arc_length).collect::<Vec<f64>>(),
        ];
        let sums = measures.each_ref().map(|measure| measure.iter().sum::<f64>().max(f64::MIN_POSITIVE));
        // Cumulative density of each line, from 0 to 1.
        let mut cumulative = vec![0.0; count];
        for at in 1..count {
            let step: f64 = measures.iter().zip(sums).map(|(measure, sum)| measure[at - 1] / sum).sum();
            cumulative[at] = cumulative[at - 1] + step / measures.len() as f64;
        }
        let mut chosen: Vec<usize> = (0..most)
            .map(|k| cumulative.partition_point(|a| *a < (k as f64 + 0.5) / most as f64).min(count - 1))
            .collect();
        chosen.dedup();
        // Each chosen line represents those nearest to it.
        let ends: Vec<usize> =
            chosen.windows(2).map(|pair| (pair[0] + pair[1]) / 2 + 1).chain([count]).collect();
        let mean = count as f64 / chosen.len() as f64;
        let mut record = self.with(chosen);
        let mut from = 0;
        for (weight, end) in record.weight.iter_mut().zip(ends) {
            *weight *= (end - from) as f64 / mean;
            from = end;
        }
        record
    }

    /// Returns the record with some of its lines.
    fn with(&self, lines: Vec<usize>) -> FrfRecord {
        fn each<T: Clone>(lines: &[usize], all: &[T]) -> Vec<T> {
            lines.iter().map(|at| all[*at].clone()).collect()
        }
        let omega_rad_s = each(&lines, &self.omega_rad_s);
        FrfRecord {
            lines: Arc::new(FrequencyGrid::new(&omega_rad_s)),
            omega_rad_s,
            log_measured: each(&lines, &self.log_measured),
            weight: each(&lines, &self.weight),
            noise_sd: each(&lines, &self.noise_sd),
            stated_sd: each(&lines, &self.stated_sd),
            ..*self
        }
    }

    /// Returns ln of the measured receptance at four lines from a line on; past the last line, that of the
    /// last.
    pub(super) fn measured(&self, line: usize) -> Complexes {
        Complexes::each(|lane| self.log_measured[(line + lane).min(self.log_measured.len() - 1)])
    }

    /// Returns the weights of four lines from a line on; past the last line, 0.
    pub(super) fn weights(&self, line: usize) -> Reals {
        Reals::from(std::array::from_fn::<_, LANES, _>(|lane| {
            self.weight.get(line + lane).copied().unwrap_or(0.0)
        }))
    }

    /// Returns the frequencies of its lines (Hz).
    pub fn frequencies_hz(&self) -> Vec<f64> {
        self.omega_rad_s.iter().map(|omega| frequency_hz(*omega)).collect()
    }

    /// Returns the magnitudes of its lines as a receptance.
    pub fn magnitudes(&self) -> Vec<f64> {
        self.log_measured.iter().map(|h| h.re.exp()).collect()
    }
}

/// Returns the operating condition of a measured FRF.
pub fn operating(set: &MeasurementSet, frf: &Frf) -> Operating {
    Operating {
        velocity_m_s: frf.condition.velocity_m_s,
        acceleration_m_s2: frf.condition.acceleration_m_s2,
        level_n: frf.condition.force_level_n,
        window_per_s: frf.condition.window_per_s,
        ..Operating::at(frf.position.and_then(|p| set.positions[p].nut_m))
    }
}

/// Physical values of unit-cube coordinates.
pub(super) struct Decoded {
    pub(super) parameters: ParameterValues,
    pub(super) log_gain: f64,
    /// Shift of each nut position (m).
    pub(super) nut_shift_m: Vec<f64>,
    /// ln(gain) and delay (s) of each channel.
    pub(super) channels: Vec<(f64, f64)>,
}

impl Decoded {
    /// Returns the operating condition of a record, with its nut position shifted.
    pub(super) fn operating(&self, record: &FrfRecord) -> Operating {
        let shift_m = self.nut_shift_m.get(record.nut).copied().unwrap_or(0.0);
        Operating { nut_m: record.operating.nut_m.map(|nut_m| nut_m + shift_m), ..record.operating }
    }

    /// Returns ln(gain) and delay (s) of a record's channel.
    pub(super) fn channel(&self, record: &FrfRecord) -> (f64, f64) {
        self.channels.get(record.structure).copied().unwrap_or((0.0, 0.0))
    }
}

/// Combines gain, delay (s) and power of iω of the measuring chain with ln(gain) and delay (s) of a channel;
/// returns ln(gain), delay, power.
pub(super) fn factor(
    (gain, delay_s, power): (f64, f64, f64),
    (log_gain, channel_delay_s): (f64, f64),
) -> (f64, f64, f64) {
    (gain.ln() + log_gain, delay_s + channel_delay_s, power)
}

/// Computes ln(recorded/receptance) of a [`factor`], as [`machine::Chain::log_factor`].
pub(super) fn log_factor((log_gain, delay_s, power): (f64, f64, f64), omega_rad_s: Reals) -> Complexes {
    let by_power = if power == 0.0 { Reals::ZERO } else { omega_rad_s.ln() * Reals::splat(power) };
    let phase =
        omega_rad_s.mul_neg_add(Reals::splat(delay_s), Reals::splat(power * std::f64::consts::FRAC_PI_2));
    Complexes::new(by_power + Reals::splat(log_gain), phase)
}

/// Wraps the imaginary part to −π … π.
pub(super) fn wrapped(z: Complexes) -> Complexes {
    let turn = Reals::splat(std::f64::consts::TAU);
    Complexes::new(z.re, (z.im / turn).round().mul_neg_add(turn, z.im))
}

/// Returns the pieces of all records in order: index of the record, and lines.
pub(super) fn pieces(records: &[FrfRecord]) -> Vec<(usize, std::ops::Range<usize>)> {
    let piece = |(at, r): (usize, &FrfRecord)| {
        let count = r.omega_rad_s.len();
        (0..count).step_by(PIECE).map(move |from| (at, from..(from + PIECE).min(count))).collect::<Vec<_>>()
    };
    records.iter().enumerate().flat_map(piece).collect()
}

/// Prepares an FRF: receptances and weights of the lines in the band.
pub(super) fn record(
    frf: &Frf,
    index: usize,
    operating: Operating,
    structure: usize,
    settings: FrfSettings,
) -> Result<FrfRecord, ObjectiveError> {
    let in_band =
        |(_, l): &(usize, &FrfLine)| (settings.band_hz.0..=settings.band_hz.1).contains(&l.frequency_hz);
    let omegas: Vec<f64> =
        frf.lines.iter().enumerate().filter(in_band).map(|(_, l)| omega_rad_s(l.frequency_hz)).collect();
    let mut record = FrfRecord {
        frf: index,
        operating,
        nut: usize::MAX,
        group: 0,
        structure,
        lines: Arc::new(FrequencyGrid::new(&omegas)),
        omega_rad_s: omegas,
        log_measured: Vec::new(),
        weight: Vec::new(),
        noise_sd: Vec::new(),
        stated_sd: Vec::new(),
    };
    let levels = if settings.of_level { levels(frf) } else { Vec::new() };
    let noise_sds = frf.component_sds();
    let stated = noise_sds.iter().any(Option::is_some);
    let mut model_errors = Vec::new();
    for (at, line) in frf.lines.iter().enumerate().filter(in_band) {
        let receptance = frf.receptance(line);
        let model_error =
            settings.model_error * levels.get(at).map_or(1.0, |level| (level / receptance.norm()).max(1.0));
        model_errors.push(model_error);
        let noise_sd = noise_sds[at];
        let sd = noise_sd.unwrap_or(0.0).hypot(model_error);
        if !(sd > 0.0) && !stated {
            let fault = "the noise of its lines is unknown; give a model error above 0 (frf_model_error)";
            return Err(ObjectiveError::Data(format!("{}: {fault}", frf.source)));
        }
        record.log_measured.push(receptance.ln());
        record.weight.push(1.0 / (sd * sd));
        record.noise_sd.push(noise_sd);
        record.stated_sd.push(frf.component_sd(line));
    }
    // A line without a stated noise has the median noise of its record, not none.
    if let Some(median_sd) = median(record.noise_sd.iter().flatten().copied()) {
        for ((weight, noise_sd), model_error) in
            record.weight.iter_mut().zip(&record.noise_sd).zip(&model_errors)
        {
            if noise_sd.is_none() {
                *weight = 1.0 / (median_sd * median_sd + model_error * model_error);
            }
        }
    }
    if record.omega_rad_s.is_empty() {
        let (from, to) = settings.band_hz;
        return Err(ObjectiveError::Data(format!(
            "{}: has no accepted line from {from} to {to} Hz; widen the frequency band (band)",
            frf.source
        )));
    }
    Ok(record)
}

/// Computes the geometric mean of the receptance over a third of an octave to either side of each line.
fn levels(frf: &Frf) -> Vec<f64> {
    let lines = &frf.lines;
    let log = |line: &FrfLine| frf.receptance(line).norm().ln();
    let (mut from, mut to, mut sum) = (0, 0, 0.0);
    lines
        .iter()
        .map(|line| {
            while to < lines.len() && lines[to].frequency_hz <= line.frequency_hz * f64::cbrt(2.0) {
                sum += log(&lines[to]);
                to += 1;
            }
            while lines[from].frequency_hz < line.frequency_hz / f64::cbrt(2.0) {
                sum -= log(&lines[from]);
                from += 1;
            }
            f64::exp(sum / (to - from) as f64)
        })
        .collect()
}

/// Checks that all FRFs fitted together overlap in frequency: otherwise one carries no information on the
/// other.
pub(super) fn check_overlap(set: &MeasurementSet, records: &[FrfRecord]) -> Result<(), ObjectiveError> {
    let ends = |r: &FrfRecord| (r.omega_rad_s[0], r.omega_rad_s[r.omega_rad_s.len() - 1]);
    for (at, a) in records.iter().enumerate() {
        for b in &records[..at] {
            let ((from_a, to_a), (from_b, to_b)) = (ends(a), ends(b));
            if from_a > to_b || from_b > to_a {
                return Err(ObjectiveError::Data(format!(
                    "{} and {} have no frequency in common; fit them in two runs, or measure both over one band",
                    set.frfs[b.frf].source, set.frfs[a.frf].source
                )));
            }
        }
    }
    Ok(())
}
