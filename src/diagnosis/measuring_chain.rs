//! Faults of the measuring chain as hypotheses, and those of all records.
//!
//! Each hypothesis corrects the measured FRFs for its fault; the nominal machine is then fitted to them as to
//! any other data.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;

use super::evidence::Domain;
use super::fit::{Fitted, Fitter, coordinates_of};
use super::hypothesis::Hypothesis;
use super::multistart::MULTISTART;
use super::policy::LEAST_UNIT;
use identification::objective::{COMMAND, ObjectiveError};
use identification::{CHI_SQUARE_95, Tail};
use long_work::Control;
use measurement::{Frf, FrfLine, Gain, MeasurementSet};
use numeric::minimum::golden_section;
use numeric::parallel::OrFirstError;
use numeric::unit::omega_rad_s;

/// A fault of the measuring chain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ChainFault {
    /// The sign is reversed: the blow and the sensor point in opposite directions.
    Polarity,
    /// The phase has the other sign: e^{−iωt}, or the cross-spectrum conjugated.
    Conjugate,
    /// The values are too large by this factor (1).
    Scale(f64),
    /// The frequencies are too large by this factor (1).
    FrequencyScale(f64),
    /// A first-order low pass with this corner (Hz).
    LowPass(f64),
    /// A first-order high pass with this corner (Hz).
    HighPass(f64),
    /// The response is late by this time (s).
    Delay(f64),
    /// The sensor stands on a soft mount of this natural frequency (Hz) and damping ratio (1).
    MountResonance(f64, f64),
    /// The quantity is this power of iω times the stated one.
    Quantity(i32),
}

/// Factors between frequency units: rad/s, 1/min and kHz for Hz, and the reverse.
pub(super) const FREQUENCY_SCALES: [f64; 6] = [TAU, 1.0 / TAU, 60.0, 1.0 / 60.0, 1e3, 1e-3];
/// Factors between units of values and what was mistaken.
const SCALES: [(f64, &str); 6] = [
    (1e3, "mm for m"),
    (1e6, "µm for m"),
    (9.80665, "g for m/s²"),
    (25.4, "inches for mm"),
    (39.370_079, "inches for m"),
    (4.448_222, "lbf for N"),
];
/// Relative distance within which a factor is taken for one of [`SCALES`] (1).
pub(super) const SAME_SCALE: f64 = 0.05;
/// Trial corners of low and high passes as shares of the highest and multiples of the lowest frequency, and
/// steps of the search between two of them.
const CORNERS: [f64; 8] = [0.3, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
const CORNER_STEPS: usize = 12;
/// Trial damping ratios of a mount (1): adhesives and magnets have few per cent, a loose sensor more.
pub(super) const MOUNT_RATIOS: [f64; 6] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5];
/// Damping ratio with which the natural frequency of the mount of all records is sought (1), in the middle of those of
/// sound mounts; it is fitted afterwards, since below its resonance a mount hardly shows it.
const MOUNT_RATIO: f64 = MOUNT_RATIOS[2];
/// Distance in the logarithm of a corner at which the rise of χ² is measured for its interval.
const SIDE: f64 = 0.05;
/// Steps of a fit to data of a trial corner, and relative decrease of χ² per step at which it ends: joints in
/// series form long valleys.
const FILTER_STEPS: (u64, f64) = (40, 1e-5);
/// Steps of a fit to corrected data.
const STEPS: u64 = 30;

impl ChainFault {
    /// Returns its id.
    pub fn id(self) -> &'static str {
        match self {
            ChainFault::Polarity => "polarity",
            ChainFault::Conjugate => "conjugate",
            ChainFault::Scale(_) => "scale",
            ChainFault::FrequencyScale(_) => "frequency-scale",
            ChainFault::LowPass(_) => "low-pass",
            ChainFault::HighPass(_) => "high-pass",
            ChainFault::Delay(_) => "measurement-delay",
            ChainFault::MountResonance(..) => "mount-resonance",
            ChainFault::Quantity(_) => "frf-quantity",
        }
    }

    /// Returns the number of parameters that it adds; a choice from a list counts as one.
    pub fn parameters(self) -> usize {
        match self {
            ChainFault::Polarity | ChainFault::Conjugate => 0,
            ChainFault::MountResonance(..) => 2,
            _ => 1,
        }
    }

    /// Whether it changes the values gradually along the frequency, as some effects do.
    pub fn is_gradual(self) -> bool {
        matches!(
            self,
            ChainFault::LowPass(_)
                | ChainFault::HighPass(_)
                | ChainFault::Delay(_)
                | ChainFault::MountResonance(..)
        )
    }

    /// Describes what is wrong with some records, with its number.
    pub fn text(self, records: &str) -> String {
        match self {
            ChainFault::Polarity => {
                format!("the sign of {records} is reversed: measured over modelled is -1 throughout")
            }
            ChainFault::Conjugate => {
                format!("the phase of {records} has the wrong sign: the values are complex conjugates")
            }
            ChainFault::Scale(factor) => {
                let near = |scale: f64| {
                    (factor / scale - 1.0).abs() < SAME_SCALE || (factor * scale - 1.0).abs() < SAME_SCALE
                };
                let cause = SCALES
                    .iter()
                    .find(|(scale, _)| near(*scale))
                    .map_or(String::new(), |(_, cause)| format!(", as of {cause}"));
                format!("the values of {records} are {}{cause}", times(factor))
            }
            ChainFault::FrequencyScale(factor) => {
                let unit = match FREQUENCY_SCALES.iter().position(|scale| *scale == factor) {
                    Some(0) => "rad/s for Hz",
                    Some(1) => "Hz divided by 2π",
                    Some(2) => "1/min for Hz",
                    Some(4) => "mHz for Hz",
                    Some(5) => "kHz for Hz",
                    _ => "another unit than Hz",
                };
                format!("the frequencies of {records} are {}: {unit}", times(factor))
            }
            ChainFault::LowPass(hz) => {
                format!("the measuring chain of {records} has a first-order low pass at {} Hz", figures(hz))
            }
            ChainFault::HighPass(hz) => {
                format!("the measuring chain of {records} has a first-order high pass at {} Hz", figures(hz))
            }
            ChainFault::Delay(delay_s) => {
                format!("the response of {records} is {} µs late", figures(1e6 * delay_s))
            }
            ChainFault::MountResonance(hz, ratio) => {
                format!(
                    "the sensor of {records} resonates on its mount at {} Hz, with a damping ratio of {}",
                    figures(hz),
                    figures(ratio)
                )
            }
            ChainFault::Quantity(power) => {
                let order = if power.abs() == 1 { "once" } else { "twice" };
                let change = if power > 0 { "differentiated" } else { "integrated" };
                format!("the values of {records} are of another quantity: the stated one, {order} {change}")
            }
        }
    }

    /// Returns the factor by which the fault multiplies an FRF; 1 for faults that are no factor.
    ///
    /// # Source  first-order filters: Bendat and Piersol, Random Data (2010), section 2.3. Mount: the
    ///   transmissibility of a mass on a spring and a
    /// damper; Rao, Mechanical Vibrations, section 3.6.
    pub fn factor(self, frequency_hz: f64) -> Complex64 {
        let omega = omega_rad_s(frequency_hz);
        match self {
            ChainFault::Polarity => Complex64::from(-1.0),
            ChainFault::Conjugate | ChainFault::FrequencyScale(_) => Complex64::ONE,
            ChainFault::Scale(factor) => Complex64::from(factor),
            ChainFault::LowPass(corner_hz) => Complex64::new(1.0, frequency_hz / corner_hz).inv(),
            ChainFault::HighPass(corner_hz) => Complex64::new(1.0, -corner_hz / frequency_hz).inv(),
            ChainFault::Delay(delay_s) => Complex64::from_polar(1.0, -omega * delay_s),
            ChainFault::MountResonance(mount_hz, ratio) => {
                let along = frequency_hz / mount_hz;
                let damping = Complex64::new(0.0, 2.0 * ratio * along);
                (1.0 + damping) / (1.0 - along * along + damping)
            }
            ChainFault::Quantity(power) => Complex64::new(0.0, omega).powi(power),
        }
    }

    /// Returns a measured line as it were without the fault.
    fn corrected(self, line: &FrfLine) -> FrfLine {
        let (frequency_hz, value) = match self {
            ChainFault::Conjugate => (line.frequency_hz, line.value.conj()),
            ChainFault::FrequencyScale(factor) => (line.frequency_hz / factor, line.value),
            _ => (line.frequency_hz, line.value / self.factor(line.frequency_hz)),
        };
        FrfLine { frequency_hz, value, ..*line }
    }

    /// Returns the set with some FRFs as they were without the fault.
    pub fn corrected_in(self, set: &MeasurementSet, concerns: impl Fn(usize) -> bool) -> MeasurementSet {
        let mut other = set.clone();
        let each = |frf: &mut Frf| frf.lines.iter_mut().for_each(|line| *line = self.corrected(line));
        other.frfs.iter_mut().enumerate().filter(|(at, _)| concerns(*at)).for_each(|(_, frf)| each(frf));
        other
    }
}

/// A fault of all records.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ChainCandidate {
    pub fault: ChainFault,
    /// 95 % interval of the corner of a filter (Hz).
    pub interval95: Option<(f64, f64)>,
    /// Least χ² of the nominal machine on the corrected data.
    pub chi_square: f64,
}

impl ChainCandidate {
    /// Describes the fault, with its number.
    pub fn text(self) -> String {
        let interval = self.interval95.map_or(String::new(), |(low, high)| {
            format!(" (95 %: {} to {} Hz)", figures(low), figures(high))
        });
        format!("{}{interval}", self.fault.text("all records"))
    }
}

/// Writes a number with three significant figures.
pub(super) fn figures(x: f64) -> String {
    let decade = x.abs().max(f64::MIN_POSITIVE).log10().floor() as i32;
    let unit = 10_f64.powi(decade - 2);
    format!("{:.*}", (2 - decade).clamp(0, 9) as usize, (x / unit).round() * unit)
}

impl ChainFault {
    /// Whether FRFs can show it on a machine: gains and times of a closed loop take up another scale of time.
    pub(super) fn is_distinct(self, fitter: &Fitter<'_>, nominal: &Hypothesis) -> bool {
        let is_loop = |frf: &Frf| frf.excitation == COMMAND && nominal.machine.point(COMMAND).is_none();
        !matches!(self, ChainFault::FrequencyScale(_)) || !fitter.fit.set().frfs.iter().any(is_loop)
    }
}

/// States a factor on what is too large or too small.
pub(super) fn times(factor: f64) -> String {
    match factor.abs() {
        x if x < 1.0 => format!("{} times too small", figures(1.0 / x)),
        x => format!("{} times too large", figures(x)),
    }
}

/// Returns the fault of all records with which the nominal machine fits best, on the corrected data; `None`
/// without FRFs.
///
/// # Errors  as [`Fitter::objective`].
pub(super) fn fault_of_all(
    fitter: &Fitter<'_>,
    (nominal, base): (&Hypothesis, &Fitted),
    control: &Control,
) -> Result<Option<ChainCandidate>, ObjectiveError> {
    let Domain::Frf(_) = fitter.domain else { return Ok(None) };
    let frequencies = FREQUENCY_SCALES.map(ChainFault::FrequencyScale);
    let frequencies = frequencies.into_iter().filter(|fault| fault.is_distinct(fitter, nominal));
    // A factor of 1 stands for a free one.
    let faults: Vec<ChainFault> = [ChainFault::Polarity, ChainFault::Conjugate, ChainFault::Scale(1.0)]
        .into_iter()
        .chain(frequencies)
        .collect();
    let coarse = |fault: &ChainFault| {
        let set = version(*fault, fitter.fit.set())?;
        let data = fitter.on(fitter.fit.in_version(&set));
        // Corrected data that cannot be compared, out of the band for example, are no explanation.
        let objective = data.objective(nominal).ok()?;
        let ends = data.multistart_ends(&objective, nominal, &without_tail(base), (MULTISTART, 0), control);
        Some((*fault, ends.into_iter().min_by(|a, b| a.chi_square.total_cmp(&b.chi_square))?))
    };
    let ends: Vec<(ChainFault, Fitted)> = faults.par_iter().filter_map(coarse).collect();
    let mut found = Vec::new();
    if let Some((fault, end)) = ends.iter().min_by(|a, b| a.1.chi_square.total_cmp(&b.1.chi_square)) {
        found.extend(refined(fitter, nominal, (*fault, end), control)?);
    }
    let (low, high) = band(fitter);
    let filters = [
        (ChainFault::LowPass as fn(f64) -> ChainFault, CORNERS.map(|share| share * high)),
        (ChainFault::HighPass, CORNERS.map(|share| low / share)),
        (|hz| ChainFault::MountResonance(hz, MOUNT_RATIO), CORNERS.map(|share| share * high)),
    ];
    let filters: Result<Vec<(ChainCandidate, Fitted)>, ObjectiveError> = filters
        .into_par_iter()
        .map(|(made, corners)| filter(fitter, (nominal, base), (made, corners), control))
        .or_first_error();
    let best = filters?.into_iter().min_by(|a, b| a.0.chi_square.total_cmp(&b.0.chi_square));
    found.extend(
        best.map(|(best, fitted)| with_damping(fitter, nominal, (best, fitted), control)).transpose()?,
    );
    // A fit that was stopped has the χ² of other lines.
    if control.stopped() {
        return Ok(None);
    }
    Ok(found.into_iter().min_by(|a, b| a.chi_square.total_cmp(&b.chi_square)))
}

/// Returns a fit whose unknowns of the data start anew.
fn without_tail(fitted: &Fitted) -> Fitted {
    Fitted { tail: Tail::default(), ..fitted.clone() }
}

/// Returns the set corrected for a fault of all records, with an unknown gain for a factor; `None` for a
/// factor where the gain is unknown anyway.
fn version(fault: ChainFault, set: &MeasurementSet) -> Option<MeasurementSet> {
    match (fault, set.gain) {
        (ChainFault::Scale(_), Gain::Unknown) => None,
        (ChainFault::Scale(_), Gain::Known(_)) => Some(MeasurementSet { gain: Gain::Unknown, ..set.clone() }),
        _ => Some(fault.corrected_in(set, |_| true)),
    }
}

/// Fits the nominal machine to all lines of corrected data; `None` for a factor near 1, which is a gain.
fn refined(
    fitter: &Fitter<'_>,
    nominal: &Hypothesis,
    (fault, from): (ChainFault, &Fitted),
    control: &Control,
) -> Result<Option<ChainCandidate>, ObjectiveError> {
    let Some(set) = version(fault, fitter.fit.set()) else { return Ok(None) };
    let data = fitter.on(fitter.fit.in_version(&set));
    let objective = data.objective(nominal)?;
    let found = data.descend(&objective, from, STEPS, control);
    let candidate = |fault| ChainCandidate { fault, interval95: None, chi_square: found.chi_square };
    Ok(match (fault, fitter.fit.set().gain) {
        (ChainFault::Scale(_), Gain::Known(stated)) => {
            let factor = objective.gain(&coordinates_of(&objective, &found)) / stated;
            let is_unit = !(1.0 / LEAST_UNIT..=LEAST_UNIT).contains(&factor);
            is_unit.then(|| candidate(ChainFault::Scale(factor)))
        }
        _ => Some(candidate(fault)),
    })
}

/// Returns the lowest and highest frequency of the fitted FRFs (Hz).
fn band(fitter: &Fitter<'_>) -> (f64, f64) {
    let lines = fitter
        .fit
        .frfs()
        .iter()
        .flat_map(|frf| &fitter.fit.set().frfs[*frf].lines)
        .map(|line| line.frequency_hz);
    lines.fold((f64::INFINITY, 0.0), |(low, high), f| (low.min(f), high.max(f)))
}

/// Fits the corner of a filter: on trial corners and few lines, then between the neighbours of the best on
/// all lines.
fn filter(
    fitter: &Fitter<'_>,
    (nominal, base): (&Hypothesis, &Fitted),
    (made, corners): (fn(f64) -> ChainFault, [f64; CORNERS.len()]),
    control: &Control,
) -> Result<(ChainCandidate, Fitted), ObjectiveError> {
    let fit = |log_corner: f64, from: &Fitted| -> Result<Fitted, ObjectiveError> {
        let set = made(log_corner.exp()).corrected_in(fitter.fit.set(), |_| true);
        let data = fitter.on(fitter.fit.in_version(&set));
        Ok(data.descend_until(&data.objective(nominal)?, from, FILTER_STEPS, control))
    };
    // A filter leads the joints astray: starts all over their ranges, on few lines.
    let coarse = |log_corner: &f64| -> Result<Option<Fitted>, ObjectiveError> {
        let set = made(log_corner.exp()).corrected_in(fitter.fit.set(), |_| true);
        let data = fitter.on(fitter.fit.in_version(&set));
        let ends = data.multistart_ends(
            &data.objective(nominal)?,
            nominal,
            &without_tail(base),
            (MULTISTART, 0),
            control,
        );
        Ok(ends.into_iter().min_by(|a, b| a.chi_square.total_cmp(&b.chi_square)))
    };
    let logs = corners.map(f64::ln);
    let ends: Result<Vec<Option<Fitted>>, ObjectiveError> = logs.par_iter().map(coarse).or_first_error();
    let ends: Vec<Fitted> = ends?.into_iter().map(|end| end.unwrap_or_else(|| base.clone())).collect();
    let best =
        (0..ends.len()).min_by(|a, b| ends[*a].chi_square.total_cmp(&ends[*b].chi_square)).unwrap_or(0);
    let neighbours = (logs[best.saturating_sub(1)], logs[(best + 1).min(logs.len() - 1)]);
    // Each fit starts from the best before it.
    let mut found = (logs[best], fit(logs[best], &ends[best])?);
    golden_section(neighbours, CORNER_STEPS, |log_corner| {
        let fitted = fit(log_corner, &found.1)?;
        let chi_square = fitted.chi_square;
        if chi_square < found.1.chi_square {
            found = (log_corner, fitted);
        }
        Ok::<f64, ObjectiveError>(chi_square)
    })?;
    let (corner, best) = found;
    // The half-width follows from the rise of χ² to either side.
    let misfit = (best.chi_square / fitter.objective(nominal)?.observations() as f64).max(1.0);
    let rise = 0.5 * (fit(corner - SIDE, &best)?.chi_square + fit(corner + SIDE, &best)?.chi_square)
        - best.chi_square;
    let half = SIDE * (CHI_SQUARE_95 * misfit / rise.max(f64::MIN_POSITIVE)).sqrt();
    let interval95 = Some(((corner - half).exp(), (corner + half).exp()));
    Ok((ChainCandidate { fault: made(corner.exp()), interval95, chi_square: best.chi_square }, best))
}

/// Fits the damping ratio of a mount, which hardly moves its natural frequency above the band; other filters
/// have none.
fn with_damping(
    fitter: &Fitter<'_>,
    nominal: &Hypothesis,
    (mut best, mut fitted): (ChainCandidate, Fitted),
    control: &Control,
) -> Result<ChainCandidate, ObjectiveError> {
    let ChainFault::MountResonance(hz, _) = best.fault else { return Ok(best) };
    let range = (MOUNT_RATIOS[0].ln(), MOUNT_RATIOS[MOUNT_RATIOS.len() - 1].ln());
    golden_section(range, CORNER_STEPS, |log_ratio| {
        let fault = ChainFault::MountResonance(hz, log_ratio.exp());
        let set = fault.corrected_in(fitter.fit.set(), |_| true);
        let data = fitter.on(fitter.fit.in_version(&set));
        let found = data.descend_until(&data.objective(nominal)?, &fitted, FILTER_STEPS, control);
        let chi_square = found.chi_square;
        if chi_square < best.chi_square {
            (best, fitted) = (ChainCandidate { fault, chi_square, ..best }, found);
        }
        Ok::<f64, ObjectiveError>(chi_square)
    })?;
    Ok(best)
}
