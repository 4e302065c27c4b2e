//! Why an FRF shows no mode.

use measurement::modal::{ModalFit, TrackRecord, TrackedMode, track};
use measurement::{Frf, FrfLine};
use numeric::statistics::median;

/// Number of FRFs of which the reasons are stated.
const MOST_STATED: usize = 3;
/// Number of lines to either side of a peak that show its surroundings.
const SURROUNDINGS: usize = 25;
/// Least width of a peak (lines): fewer do not determine frequency and damping.
const LEAST_WIDTH: usize = 3;
/// Noise of |H| (1) above which modes are lost in it.
const MUCH_NOISE: f64 = 0.2;

/// Fits an FRF.
type Fit<'f> = &'f dyn Fn(&Frf) -> Option<ModalFit>;
/// Returns the band (Hz) of an FRF that is fitted.
type Band<'f> = &'f dyn Fn(&Frf) -> (f64, f64);

/// States why FRFs show no mode, one sentence for each of the first ones.
pub(crate) fn reasons_for_no_mode(frfs: &[Frf], fit: Fit<'_>, band_hz: Band<'_>) -> Vec<String> {
    let mut reasons: Vec<String> =
        frfs.iter().take(MOST_STATED).map(|frf| reason(frf, fit, band_hz(frf))).collect();
    if frfs.len() > MOST_STATED {
        reasons.push(format!("{} further FRFs show no mode either", frfs.len() - MOST_STATED));
    }
    reasons
}

fn reason(frf: &Frf, fit: Fit<'_>, (from, to): (f64, f64)) -> String {
    let source = &frf.source;
    if let Some(mode) = mode_of_conjugate(frf, fit, (from, to)) {
        return format!(
            "{source}: shows no mode, but the complex conjugates of its values do, at {:.1} Hz: the phase rises through the peak, which it does in no structure; reverse the sign of the imaginary parts (H = response/force, e^+iωt)",
            mode.frequency_hz
        );
    }
    let lines: Vec<&FrfLine> =
        frf.lines.iter().filter(|line| (from..=to).contains(&line.frequency_hz)).collect();
    let Some((top, over)) = largest_peak(&lines) else {
        return format!(
            "{source}: shows no mode: |H| has no peak from {from} to {to} Hz; measure a wider band"
        );
    };
    let size = lines[top].value.norm();
    let is_high = |line: &&&FrfLine| line.value.norm() > size * std::f64::consts::FRAC_1_SQRT_2;
    let width = lines[top..].iter().take_while(is_high).count()
        + lines[..top].iter().rev().take_while(is_high).count();
    let noise = median(frf.component_sds().into_iter().flatten()).map(|sd| sd * std::f64::consts::SQRT_2);
    let mut causes = Vec::new();
    if width < LEAST_WIDTH {
        causes.push(format!(
            "it is {width} line{} wide, too narrow for frequency and damping: measure with finer lines",
            if width == 1 { "" } else { "s" }
        ));
    }
    if let Some(noise) = noise.filter(|noise| *noise > MUCH_NOISE) {
        causes.push(format!("the noise is {:.0} % of |H|: take more averages", 100.0 * noise));
    }
    if causes.is_empty() {
        causes.push("its pole differs from order to order of the fit: choose a narrower band".into());
    }
    let peak = format!(
        "the largest peak, at {:.1} Hz, is {over:.1} times its surroundings",
        lines[top].frequency_hz
    );
    format!("{source}: shows no mode; {peak}; {}", causes.join("; "))
}

/// Returns the strongest mode of the complex conjugate of an FRF.
fn mode_of_conjugate(frf: &Frf, fit: Fit<'_>, band_hz: (f64, f64)) -> Option<TrackedMode> {
    let mut conjugate = frf.clone();
    conjugate.lines.iter_mut().for_each(|line| line.value = line.value.conj());
    let fitted = fit(&conjugate)?;
    let record = TrackRecord { nut_m: None, series: "", band_hz, modes: &fitted.modes };
    let modes = track(&[record]).into_iter().filter(|mode| mode.regular);
    modes.max_by(|a, b| a.evidence.signal_to_noise.total_cmp(&b.evidence.signal_to_noise))
}

/// Returns the line of the peak that stands highest over its surroundings, and its height over them (1).
fn largest_peak(lines: &[&FrfLine]) -> Option<(usize, f64)> {
    let size = |at: usize| lines[at].value.norm();
    let inner = 1..lines.len().saturating_sub(1);
    let peaks = inner.filter(|at| size(*at) > size(at - 1) && size(*at) >= size(at + 1));
    let over = |at: usize| {
        let around = at.saturating_sub(SURROUNDINGS)..(at + SURROUNDINGS + 1).min(lines.len());
        Some((at, size(at) / median(around.map(size))?))
    };
    peaks.filter_map(over).max_by(|a, b| a.1.total_cmp(&b.1))
}
