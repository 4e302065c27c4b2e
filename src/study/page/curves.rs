//! Measured FRFs and the predictions of one or two models, for the HTML report.

use num_complex::Complex64;

use crate::frequency_response::Evaluated;
use crate::modal_density::mode_frequencies_hz;
use crate::{StudyError, StudyResult};
use dynamics::model::RodModel;
use identification::objective::{
    Excitation, FrfObjective, FrfSettings, ModeObjective, ModeSettings, operating,
};
use machine::{Chain, Machine, Operating, ParameterValues, PointMotion};
use measurement::{FitSet, Frf, Gain, HoldOutSet, MeasurementSet, Quantity};
use numeric::statistics::{extremes, median};
use numeric::unit::omega_rad_s;
use report::page::{PageCurve, PeakMark};

/// Number of frequency lines of a predicted FRF where none was measured, evenly spaced in ln f.
const LINES: usize = 1500;
/// Ends of the predicted band over the lowest and the highest measured natural frequency (1): the flanks of
/// both peaks lie inside.
const BAND_ENDS: (f64, f64) = (0.4, 1.4);
/// Number of extra lines on each side of a predicted peak.
const PEAK_LINES: i32 = 100;
/// Distance of the first extra line from the peak, relative to its frequency (1). The i-th line lies i³ times
/// as far: dense at the peak, up to 2 % from it.
const PEAK_SPACING: f64 = 2e-8;

/// Spacing of two lines over the median of their surroundings from which lines are missing between them (1).
const GAP: f64 = 2.5;
/// Number of spacings to either side that are the surroundings.
const AROUND: usize = 4;

/// A line of an FRF: frequency (Hz), and value in the displayed unit.
type FrfSample = (f64, Complex64);

/// A machine with the values of its parameters.
pub(super) struct CurveModel {
    pub(super) machine: Machine,
    /// Values of the parameters, in the order of the machine.
    pub(super) values: ParameterValues,
    /// Model of the rods.
    pub(super) rods: RodModel,
    /// Gain: factor from prediction to record (1). Where it is absent, it is fitted to the measurements.
    pub(super) gain: Option<f64>,
}

/// A measurement set, its fitted part, and the models drawn over it. The last model is the result.
pub(super) struct Overlay<'o> {
    pub(super) set: &'o MeasurementSet,
    /// Fitted positions and FRFs; the others are drawn as held out.
    pub(super) fit: FitSet<'o>,
    pub(super) models: &'o [CurveModel],
}

impl Overlay<'_> {
    /// Returns all FRFs of the set with their predictions. For a set of modes it returns predictions over the
    /// band of its modes.
    pub(super) fn curves(&self) -> StudyResult<Vec<PageCurve>> {
        let gains = self.models.iter().map(|m| self.gain(m)).collect::<StudyResult<Vec<f64>>>()?;
        if self.set.frfs.is_empty() {
            self.mode_curves(&gains)
        } else {
            self.set.frfs.iter().enumerate().map(|(at, frf)| self.frf_curve(at, frf, &gains)).collect()
        }
    }

    /// Returns all positions and FRFs of the set, fitted and held out.
    fn all_data(&self) -> HoldOutSet<'_> {
        self.set.everything_to_predict()
    }

    /// Returns the gain of a model: the factor from its prediction to the record (1).
    ///
    /// An unknown gain is fitted to all positions. It belongs to the measuring chain, which is the same for
    /// fitted and held-out positions. It only scales the drawn curves.
    fn gain(&self, model: &CurveModel) -> StudyResult<f64> {
        match (self.set.gain, model.gain) {
            (Gain::Known(gain), _) | (Gain::Unknown, Some(gain)) => Ok(gain),
            (Gain::Unknown, None) if self.set.frfs.is_empty() => {
                let settings = ModeSettings { rods: model.rods, ..ModeSettings::default() };
                let objective = ModeObjective::held_out(&model.machine, &self.all_data(), settings, None)?;
                Ok(objective.amplitude_fit(&objective.predict(&model.values)).gain)
            }
            (Gain::Unknown, None) => {
                let settings = FrfSettings { rods: model.rods, ..FrfSettings::default() };
                let objective = FrfObjective::held_out(&model.machine, &self.all_data(), settings)?;
                Ok(objective.best_gain(&model.values))
            }
        }
    }

    /// Predicts a recorded response with every model, times a unit factor. Returns the curves of the result
    /// and of the model before it.
    fn predicted(
        &self,
        channel: (&str, &str),
        (quantity, factor): (Quantity, f64),
        operating: &Operating,
        lines: &[f64],
        gains: &[f64],
    ) -> StudyResult<(Vec<FrfSample>, Vec<FrfSample>)> {
        let models = self.models.iter().zip(gains);
        let mut all = models
            .map(|(m, gain)| m.predicted(channel, quantity, operating, lines, factor * gain))
            .collect::<Result<Vec<_>, _>>()?;
        Ok((all.pop().unwrap_or_default(), all.pop().unwrap_or_default()))
    }

    /// Returns a measured FRF with its predictions at the same lines, and where lines are missing.
    fn frf_curve(&self, at: usize, frf: &Frf, gains: &[f64]) -> StudyResult<PageCurve> {
        let set = self.set;
        let operating = operating(set, frf);
        let (factor, unit) = self.unit((&frf.response, &frf.excitation), frf.quantity)?;
        let measured = with_breaks(frf, factor);
        let lines: Vec<f64> = measured.iter().map(|(frequency_hz, _)| *frequency_hz).collect();
        let (predicted, before) = self.predicted(
            (&frf.response, &frf.excitation),
            (frf.quantity, factor),
            &operating,
            &lines,
            gains,
        )?;
        let channel = format!("{}/{}", frf.response, frf.excitation);
        let name = |p: usize| set.positions[p].name.clone();
        // Without a position the record names the curve. Where a position has several records, the record is
        // added to the channel.
        let several = |p: usize| {
            set.frfs.iter().filter(|f| f.position == Some(p) && f.response == frf.response).count() > 1
        };
        let (position, channel) = match (frf.position, &frf.record) {
            (Some(p), Some(record)) if several(p) => (name(p), format!("{channel} {record}")),
            (Some(p), _) => (name(p), channel),
            (None, Some(record)) => (record.clone(), channel),
            (None, None) => ("all".into(), channel),
        };
        Ok(PageCurve {
            position,
            channel,
            held_out: !self.fit.frfs().contains(&at),
            unit,
            measured,
            predicted,
            before,
            peaks: Vec::new(),
        })
    }

    /// Returns predicted FRFs of the measured channel at all positions, with the measured modes as marks.
    fn mode_curves(&self, gains: &[f64]) -> StudyResult<Vec<PageCurve>> {
        let set = self.set;
        let (Some(modes), Some(response), Some(excitation)) = (&set.modes, &set.response, &set.excitation)
        else {
            return Ok(Vec::new());
        };
        let quantity = set.quantity.unwrap_or(Quantity::Receptance);
        let (factor, unit) = self.unit((response, excitation), quantity)?;
        let (low, high) = extremes(&mode_frequencies_hz(set));
        let (from, to) = (BAND_ENDS.0 * low, BAND_ENDS.1 * high);
        // A peak may be narrower than the line spacing: lines are added around it.
        let mut peaks: Vec<Vec<f64>> = vec![Vec::new(); set.positions.len()];
        for model in self.models {
            let settings = ModeSettings { rods: model.rods, ..ModeSettings::default() };
            let objective = ModeObjective::held_out(&model.machine, &self.all_data(), settings, None)?;
            for prediction in objective.predict(&model.values) {
                peaks[prediction.position].extend(prediction.peaks.iter().map(|p| p.frequency_hz));
            }
        }
        let mut curves = Vec::new();
        for (at, (position, observed)) in set.positions.iter().zip(&modes.positions).enumerate() {
            let mut lines: Vec<f64> =
                (0..LINES).map(|i| from * (to / from).powf(i as f64 / (LINES - 1) as f64)).collect();
            for peak in peaks[at].iter().filter(|f| (from..=to).contains(*f)) {
                lines.extend(
                    (-PEAK_LINES..=PEAK_LINES).map(|i| peak * (1.0 + PEAK_SPACING * f64::from(i).powi(3))),
                );
            }
            lines.retain(|f| *f > 0.0);
            lines.sort_by(f64::total_cmp);
            lines.dedup();
            let (predicted, before) = self.predicted(
                (response, excitation),
                (quantity, factor),
                &Operating::at(position.nut_m),
                &lines,
                gains,
            )?;
            curves.push(PageCurve {
                position: position.name.clone(),
                channel: format!("{response}/{excitation}"),
                held_out: !self.fit.positions().contains(&at),
                unit: unit.clone(),
                measured: Vec::new(),
                predicted,
                before,
                peaks: observed
                    .iter()
                    .filter_map(|m| {
                        Some(PeakMark {
                            order: m.order,
                            frequency_hz: m.frequency_hz?,
                            amplitude: m.amplitude.map(|a| a * factor),
                        })
                    })
                    .collect(),
            });
        }
        Ok(curves)
    }

    /// Returns scale factor and display unit of an FRF, such as 1e6 and µm/N for a receptance in m/N.
    fn unit(&self, (response, excitation): (&str, &str), quantity: Quantity) -> StudyResult<(f64, String)> {
        let Some(machine) = self.models.last().map(|m| &m.machine) else {
            return Ok((1.0, quantity.word().into()));
        };
        let (factor, length, angle) = match quantity {
            Quantity::Receptance => (1e6, "µm", "µrad"),
            Quantity::Mobility => (1e3, "mm/s", "mrad/s"),
            Quantity::Accelerance => (1.0, "m/s²", "rad/s²"),
        };
        let translates = |name: &str| {
            Ok::<_, StudyError>(
                machine.points[point_index(machine, name)?].motion == PointMotion::Translation,
            )
        };
        let output = if translates(response)? { length } else { angle };
        let gain_note = if self.set.gain == Gain::Unknown { ", times the gain" } else { "" };
        if matches!(Excitation::named(machine, "the set", excitation)?, Excitation::Command) {
            return Ok((1.0, format!("position over command{gain_note} (1)")));
        }
        let input = if translates(excitation)? { "N" } else { "N·m" };
        Ok((factor, format!("{}{gain_note} ({output}/{input})", quantity.word())))
    }
}

/// Returns the lines of an FRF times a factor, NaN where they are missing or were not accepted.
fn with_breaks(frf: &Frf, factor: f64) -> Vec<FrfSample> {
    let none = Complex64::new(f64::NAN, f64::NAN);
    let accepted = frf.lines.iter().map(|l| (l.frequency_hz, l.value * factor));
    let rejected = frf.rejected.iter().filter(|l| l.frequency_hz > 0.0).map(|l| (l.frequency_hz, none));
    let mut lines: Vec<FrfSample> = accepted.chain(rejected).collect();
    lines.sort_by(|a, b| a.0.total_cmp(&b.0));
    let spacings: Vec<f64> = lines.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    let missing = spacings.iter().enumerate().flat_map(|(at, spacing)| {
        let around = &spacings[at.saturating_sub(AROUND)..(at + AROUND + 1).min(spacings.len())];
        let ratio = spacing / median(around.iter().copied()).unwrap_or(*spacing);
        let count = if ratio > GAP { (ratio.round() as usize - 1).min(LINES) } else { 0 };
        let (from, step) = (lines[at].0, spacing / (count + 1) as f64);
        (1..=count).map(move |n| (from + step * n as f64, none))
    });
    let missing: Vec<FrfSample> = missing.collect();
    lines.extend(missing);
    lines.sort_by(|a, b| a.0.total_cmp(&b.0));
    lines
}

/// Returns the index of a point, or a message.
fn point_index(machine: &Machine, name: &str) -> StudyResult<usize> {
    machine.point(name).ok_or_else(|| StudyError::impossible(format!("the machine has no point «{name}»")))
}

impl CurveModel {
    /// Predicts a recorded response at frequencies `lines` (Hz), times a factor. Lines without a finite value
    /// are left out.
    fn predicted(
        &self,
        (response, excitation): (&str, &str),
        quantity: Quantity,
        operating: &Operating,
        lines: &[f64],
        scale: f64,
    ) -> StudyResult<Vec<FrfSample>> {
        let machine = &self.machine;
        let (response, excitation) =
            (point_index(machine, response)?, Excitation::named(machine, "the set", excitation)?);
        let evaluated = Evaluated { machine, values: &self.values, operating: *operating, rods: self.rods };
        let chain = machine.chain.at(&self.values, operating);
        let omegas: Vec<f64> = lines.iter().copied().map(omega_rad_s).collect();
        let recorded =
            |omega: f64| quantity.from_receptance(omega) * Chain::log_factor(chain, omega).exp() * scale;
        let all = evaluated
            .response(response, excitation, false, &omegas)?
            .into_iter()
            .zip(&omegas)
            .map(|(h, omega)| h * recorded(*omega));
        Ok(lines.iter().copied().zip(all).filter(|(_, h)| h.is_finite()).collect())
    }
}
