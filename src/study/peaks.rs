//! Natural frequencies from FRFs, tracked over the positions.

use std::fmt::Write as _;

use rayon::prelude::*;

use crate::no_mode::reasons_for_no_mode;
use crate::stamp::set_stamp;
use crate::{StudyError, StudyResult};
use long_work::Control;
pub use measurement::modal::DiagramPole;
use measurement::modal::{
    AmplitudeKind, CurveFit, CurveOptions, FittedMode, FrfCurve, ModalError, ModalFit, TrackRecord,
    fit_curve, stabilisation_diagram, track, with_curve_of,
};
use measurement::{Frf, FrfLine, MeasurementSet, level_warning};
use numeric::parallel::OrFirstError;
use numeric::unit::omega_rad_s;
use report::csv_cell;
use report::document::{EvidenceRow, PeakFitRow, PeakModeRow, PeakRow, PeaksDocument};

/// Settings of the extraction of peaks.
#[derive(Debug, Clone, PartialEq)]
pub struct PeaksRequest {
    /// Lowest and highest frequency (Hz); all frequencies by default.
    pub band_hz: Option<(f64, f64)>,
    /// Whether only the modes in the band are fitted; modes outside it enter as a background linear in
    /// frequency.
    pub local: bool,
    /// Highest polynomial order of the stabilisation diagram.
    pub max_order: usize,
}

impl Default for PeaksRequest {
    fn default() -> Self {
        PeaksRequest { band_hz: None, local: false, max_order: 48 }
    }
}

/// Extracted peaks.
#[derive(Debug, Clone, PartialEq)]
pub struct Peaks {
    /// The document.
    pub document: PeaksDocument,
    /// Regular modes as the mode table of a measurement set: position, mode number, frequency (Hz), amplitude
    /// (unit of the FRFs); empty without such modes.
    pub modes_csv: String,
}

/// A fitted FRF with its unique name.
struct NamedFrf<'s> {
    name: String,
    frf: &'s Frf,
    nut_m: Option<f64>,
    fitted: ModalFit,
}

/// Extracts natural frequencies, damping ratios and amplitudes from the FRFs of a set, and tracks them over
/// its positions. `control` counts the fitted FRFs.
///
/// # Errors  the set holds no FRF; the band is not a range of frequencies; an FRF has too few lines.
pub fn peaks(set: &MeasurementSet, request: &PeaksRequest, control: &Control) -> StudyResult<Peaks> {
    if set.frfs.is_empty() {
        return Err(StudyError::input(
            &set.path,
            "holds no FRF; list at least one as [[frf]] in its manifest",
        ));
    }
    let options = options(request)?;
    let names = names(set);
    let step = control.steps("FRFs", set.frfs.len());
    let fitted: StudyResult<Vec<NamedFrf>> = set
        .frfs
        .par_iter()
        .zip(names)
        .map(|(frf, name)| {
            if control.stopped() {
                return Err(StudyError::Stopped);
            }
            let fitted =
                fit(frf, &options, request).map_err(|e| StudyError::input(&frf.source, e.to_string()))?;
            step();
            Ok(NamedFrf { name, frf, nut_m: frf.position.and_then(|p| set.positions[p].nut_m), fitted })
        })
        .or_first_error();
    let named = fitted?;
    let series: Vec<String> = named
        .iter()
        .map(|NamedFrf { frf, .. }| {
            format!("{}/{} {} {:?}", frf.response, frf.excitation, frf.quantity.word(), frf.condition)
        })
        .collect();
    let records: Vec<TrackRecord> = named
        .iter()
        .zip(&series)
        .map(|(n, series)| TrackRecord {
            nut_m: n.nut_m,
            series,
            band_hz: band_of(n.frf, request),
            modes: &n.fitted.modes,
        })
        .collect();
    let tracked = track(&records);
    // Regular modes have the first numbers.
    let (regular, others): (Vec<_>, Vec<_>) = tracked.iter().partition(|mode| mode.regular);
    let modes: Vec<PeakModeRow> = regular
        .into_iter()
        .chain(others)
        .enumerate()
        .map(|(at, mode)| PeakModeRow {
            order: at + 1,
            regular: mode.regular,
            frequency_hz: mode.frequency_hz,
            records: mode
                .sightings
                .iter()
                .map(|(record, at)| {
                    (named[*record].name.clone(), peak_row(&named[*record].fitted.modes[*at]))
                })
                .collect(),
            evidence: EvidenceRow {
                observed: mode.evidence.seen,
                expected: mode.evidence.expected,
                roughness: mode.evidence.roughness,
                stability: mode.evidence.stability,
                signal_to_noise: mode.evidence.signal_to_noise,
                reasons: mode.evidence.reasons.clone(),
            },
        })
        .collect();
    let fits = named
        .iter()
        .map(|n| {
            let row = PeakFitRow {
                lines: n.fitted.lines,
                relative_misfit: n.fitted.relative_misfit,
                modes: n.fitted.modes.len(),
            };
            (n.name.clone(), row)
        })
        .collect();
    let mut stamp = set_stamp("peaks", set);
    stamp.warnings.extend(window_warning(set).into_iter().chain(level_warning(&set.frfs)));
    if !modes.iter().any(|mode| mode.regular) {
        stamp.warnings.extend(reasons_for_no_mode(
            &set.frfs,
            &|frf| fit(frf, &options, request).ok(),
            &|frf| band_of(frf, request),
        ));
    }
    let document = PeaksDocument { stamp, amplitude_unit: amplitude_unit(set), modes, fits };
    Ok(Peaks { modes_csv: modes_csv(set, &named, &document), document })
}

/// Returns the row of a fitted mode.
fn peak_row(fitted: &FittedMode) -> PeakRow {
    PeakRow {
        frequency_hz: fitted.frequency_hz,
        frequency_sd_hz: finite(fitted.frequency_sd_hz),
        damping_ratio: fitted.damping_ratio,
        damping_sd: finite(fitted.damping_sd),
        amplitude: fitted.amplitude.value,
        amplitude_sd: finite(fitted.amplitude.sd),
        own_peak: fitted.amplitude.kind == AmplitudeKind::Peak,
        stable_share: fitted.stability.share(),
    }
}

/// Computes the stabilisation diagram of an FRF, by its index in the set.
///
/// # Errors  as [`peaks`]; the set has no FRF of this index.
pub fn stabilisation(
    set: &MeasurementSet,
    frf: usize,
    request: &PeaksRequest,
) -> StudyResult<Vec<DiagramPole>> {
    let Some(frf) = set.frfs.get(frf) else {
        return Err(StudyError::setting(
            "frf",
            frf,
            format!("the set has {} FRFs, counted from 0", set.frfs.len()),
        ));
    };
    let options = options(request)?;
    with_curve(frf, request, |curve| stabilisation_diagram(curve, &options))
        .map_err(|e| StudyError::input(&frf.source, e.to_string()))
}

/// Warns of FRFs with an exponential window: it adds σ/ω to the damping ratios of their modes.
fn window_warning(set: &MeasurementSet) -> Option<String> {
    let largest_per_s = set.frfs.iter().map(|frf| frf.condition.window_per_s).fold(0.0, f64::max);
    let at_100_hz = 100.0 * largest_per_s / omega_rad_s(100.0);
    (largest_per_s > 0.0).then(|| {
        format!(
            "{}: exponential windows add to these damping ratios up to {at_100_hz:.2} % at 100 Hz, and more at lower frequencies in inverse proportion; fits of \
             whole FRFs account for the windows",
            set.path
        )
    })
}

/// Returns the unit of the amplitudes; empty if the FRFs differ in quantity.
fn amplitude_unit(set: &MeasurementSet) -> String {
    let first = set.frfs.first().map(|frf| frf.quantity);
    let unit = first
        .filter(|quantity| set.frfs.iter().all(|frf| frf.quantity == *quantity))
        .map(measurement::Quantity::unit);
    unit.unwrap_or_default().to_string()
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

/// Returns the settings of the fit.
///
/// # Errors  an order out of range; a local fit without a band; a band that is not a range of frequencies.
fn options(request: &PeaksRequest) -> StudyResult<CurveOptions> {
    if !(8..=120).contains(&request.max_order) {
        return Err(StudyError::setting(
            "max_order",
            request.max_order,
            "write a polynomial order from 8 to 120",
        ));
    }
    let fit = match (request.band_hz, request.local) {
        (None, true) => {
            return Err(StudyError::setting(
                "local",
                "",
                "name the band, its lowest and highest frequency in Hz",
            ));
        }
        (Some((from_hz, to_hz)), _) if !(from_hz >= 0.0 && to_hz > from_hz && to_hz.is_finite()) => {
            let fault = "write the lowest and the highest frequency in Hz, such as 20,800";
            return Err(StudyError::setting("band_hz", "", fault));
        }
        (Some((from_hz, to_hz)), true) => CurveFit::Local { from_hz, to_hz },
        (_, false) => CurveFit::Full,
    };
    Ok(CurveOptions { fit, max_order: request.max_order })
}

/// Returns the lowest and highest frequency (Hz) of an FRF within the requested band.
fn band_of(frf: &Frf, request: &PeaksRequest) -> (f64, f64) {
    let ends =
        (frf.lines.first().map_or(0.0, |l| l.frequency_hz), frf.lines.last().map_or(0.0, |l| l.frequency_hz));
    match request.band_hz {
        Some((from, to)) => (ends.0.max(from), ends.1.min(to)),
        None => ends,
    }
}

/// Fits an FRF as a receptance.
fn fit(frf: &Frf, options: &CurveOptions, request: &PeaksRequest) -> Result<ModalFit, ModalError> {
    with_curve(frf, request, |curve| fit_curve(curve, options))
}

/// Does a piece of work on the requested lines of an FRF as a receptance.
fn with_curve<T>(frf: &Frf, request: &PeaksRequest, work: impl FnOnce(&FrfCurve) -> T) -> T {
    let (from, to) = band_of(frf, request);
    // A local fit also uses the lines outside its band; a full fit uses only those inside.
    let is_used = |l: &FrfLine| request.local || (from..=to).contains(&l.frequency_hz);
    with_curve_of(frf, is_used, work)
}

/// Names each FRF by its position, its record or its file. Record, channel and number are added if the names
/// are not unique otherwise.
fn names(set: &MeasurementSet) -> Vec<String> {
    let base = |frf: &Frf| match (frf.position, &frf.record) {
        (Some(position), _) => set.positions[position].name.clone(),
        (None, Some(record)) => record.clone(),
        (None, None) => frf.source.clone(),
    };
    let with_record = |frf: &Frf| match (frf.position, &frf.record) {
        (Some(_), Some(record)) => format!("{} {record}", base(frf)),
        _ => base(frf),
    };
    let with_channel = |frf: &Frf| format!("{} {}/{}", base(frf), frf.response, frf.excitation);
    let full = |frf: &Frf| format!("{} {}/{}", with_record(frf), frf.response, frf.excitation);
    let candidates: [&dyn Fn(&Frf) -> String; 4] = [&base, &with_record, &with_channel, &full];
    let unique = |name: &dyn Fn(&Frf) -> String| {
        let mut all: Vec<String> = set.frfs.iter().map(name).collect();
        all.sort();
        all.windows(2).all(|w| w[0] != w[1])
    };
    match candidates.into_iter().find(|name| unique(*name)) {
        Some(name) => set.frfs.iter().map(name).collect(),
        None => set.frfs.iter().enumerate().map(|(at, frf)| format!("{} {}", full(frf), at + 1)).collect(),
    }
}

/// Formats the regular modes as the mode table of a measurement set: position, mode number, frequency (Hz),
/// amplitude (unit of the FRFs); empty without such modes.
fn modes_csv(set: &MeasurementSet, named: &[NamedFrf<'_>], document: &PeaksDocument) -> String {
    if !document.modes.iter().any(|mode| mode.regular) {
        return String::new();
    }
    let mut text = String::from("position,order,frequency_hz,amplitude\n");
    for n in named.iter().filter(|n| n.frf.position.is_some()) {
        let position = csv_cell(n.frf.position.map_or("", |p| set.positions[p].name.as_str()));
        for mode in document.modes.iter().filter(|m| m.regular) {
            if let Some(peak) = mode.records.get(&n.name) {
                let _ =
                    writeln!(text, "{position},{},{},{:e}", mode.order, peak.frequency_hz, peak.amplitude);
            }
        }
    }
    text
}
