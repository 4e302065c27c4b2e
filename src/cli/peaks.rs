//! `jointid peaks`: natural frequencies from FRFs, tracked over the positions.

use std::fmt::Write as _;

use rayon::prelude::*;

use crate::arguments::OutputArguments;
use crate::outcome::{CommandResult, Outcome, deliver_with, prepare, print_out, to_message};
use crate::sources::set_stamp;
use measurement::modal::{AmplitudeKind, CurveFit, CurveOptions, FrfCurve, ModalFit, TrackOptions, TrackRecord, track};
use measurement::{Frf, FrfLine, MeasurementSet, read_set};
use numeric::parallel::OrFirstError;
use numeric::unit::omega_rad_s;
use report::document::{EvidenceRow, PeakFitRow, PeakModeRow, PeakRow, PeaksDocument};
use report::peaks_table;

/// Arguments of `peaks`.
#[derive(Debug, clap::Args)]
pub struct PeaksArguments {
    /// Folder of the measurement set
    #[arg(long, value_name = "DIR")]
    pub measurements: String,
    /// Lowest and highest frequency (Hz), comma-separated; all frequencies by default
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',', num_args = 1)]
    pub band: Vec<f64>,
    /// Fit only the modes in --band; modes outside it enter as a background linear in frequency
    #[arg(long)]
    pub local: bool,
    /// Highest polynomial order of the stabilisation diagram
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u8).range(8..=120))]
    pub max_order: u8,
    /// Also show spurious modes, which do not vary smoothly over the positions, with the reasons
    #[arg(long)]
    pub all: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// A fitted FRF with its unique name.
struct NamedFrf<'s> {
    name: String,
    frf: &'s Frf,
    nut_m: Option<f64>,
    fitted: ModalFit,
}

/// Runs the command.
pub fn run(given: &PeaksArguments) -> CommandResult {
    let set = read_set(&given.measurements).map_err(to_message)?;
    if set.frfs.is_empty() {
        return Err(format!("{}: holds no FRF; list at least one as [[frf]] in its manifest", set.path));
    }
    let options = options(given)?;
    let names = names(&set);
    let fitted: Result<Vec<NamedFrf>, String> = set
        .frfs
        .par_iter()
        .zip(names)
        .map(|(frf, name)| {
            let fitted = fit(frf, &options, given).map_err(|e| format!("{}: {e}", frf.source))?;
            Ok(NamedFrf { name, frf, nut_m: frf.position.and_then(|p| set.positions[p].nut_m), fitted })
        })
        .or_first_error();
    let named = fitted?;
    let series: Vec<String> = named.iter().map(|n| format!("{}/{} {}", n.frf.response, n.frf.excitation, n.frf.quantity.word())).collect();
    let records: Vec<TrackRecord> = named
        .iter()
        .zip(&series)
        .map(|(n, series)| TrackRecord { name: &n.name, nut_m: n.nut_m, series, band_hz: band_of(n.frf, given), modes: &n.fitted.modes })
        .collect();
    let tracked = track(&records, &TrackOptions::default()).map_err(|e| format!("{}: {e}", set.path))?;
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
                    let fitted = &named[*record].fitted.modes[*at];
                    let row = PeakRow {
                        frequency_hz: fitted.frequency_hz,
                        frequency_sd_hz: finite(fitted.frequency_sd_hz),
                        damping_ratio: fitted.damping_ratio,
                        damping_sd: finite(fitted.damping_sd),
                        amplitude: fitted.amplitude.value,
                        amplitude_sd: finite(fitted.amplitude.sd),
                        own_peak: fitted.amplitude.kind == AmplitudeKind::Peak,
                        stable_share: fitted.stability.share(),
                    };
                    (named[*record].name.clone(), row)
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
            let row = PeakFitRow { lines: n.fitted.lines, relative_misfit: n.fitted.relative_misfit, modes: n.fitted.modes.len() };
            (n.name.clone(), row)
        })
        .collect();
    let document = PeaksDocument { stamp: set_stamp("peaks", &set), amplitude_unit: amplitude_unit(&set), modes, fits };
    let folder = prepare(&given.output)?;
    let tables = [("modes.csv", modes_csv(&set, &named, &document))];
    deliver_with(&given.output, folder.as_ref(), ("peaks.json", &tables), &document, &peaks_table(&document, given.all))?;
    if !given.output.json && !given.all && document.modes.iter().any(|m| !m.regular) {
        let spurious = document.modes.iter().filter(|m| !m.regular).count();
        print_out(&format!("{spurious} spurious modes are not shown; --all shows them with the reasons\n"))?;
    }
    Ok(Outcome::Done)
}

/// Returns the unit of the amplitudes; empty if the FRFs differ in quantity.
fn amplitude_unit(set: &MeasurementSet) -> String {
    let first = set.frfs.first().map(|frf| frf.quantity);
    let unit = first.filter(|quantity| set.frfs.iter().all(|frf| frf.quantity == *quantity)).map(measurement::Quantity::unit);
    unit.unwrap_or_default().to_string()
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

/// Returns the settings of the fit.
///
/// # Errors  `--local` without a band; a band that is not a range of frequencies.
fn options(given: &PeaksArguments) -> Result<CurveOptions, String> {
    let fit = match (&given.band[..], given.local) {
        ([], false) => CurveFit::Full,
        ([], true) => return Err("--local: name the band with --band FROM,TO".into()),
        ([from, to], _) if *from >= 0.0 && to > from && to.is_finite() => {
            if given.local {
                CurveFit::Local { from_hz: *from, to_hz: *to }
            } else {
                CurveFit::Full
            }
        }
        _ => return Err("--band: write the lowest and the highest frequency in Hz, such as --band 20,800".into()),
    };
    Ok(CurveOptions { fit, max_order: usize::from(given.max_order), ..CurveOptions::default() })
}

/// Returns the lowest and highest frequency (Hz) of an FRF within the requested band.
fn band_of(frf: &Frf, given: &PeaksArguments) -> (f64, f64) {
    let ends = (frf.lines.first().map_or(0.0, |l| l.frequency_hz), frf.lines.last().map_or(0.0, |l| l.frequency_hz));
    match given.band[..] {
        [from, to] => (ends.0.max(from), ends.1.min(to)),
        _ => ends,
    }
}

/// Fits an FRF as a receptance.
fn fit(frf: &Frf, options: &CurveOptions, given: &PeaksArguments) -> Result<ModalFit, measurement::modal::ModalError> {
    let (from, to) = band_of(frf, given);
    // A local fit also uses the lines outside its band; a full fit uses only those inside.
    let is_used = |l: &FrfLine| given.local || (from..=to).contains(&l.frequency_hz);
    let lines: Vec<_> = frf.lines.iter().zip(frf.component_sds()).filter(|(l, _)| is_used(l)).collect();
    let frequency_hz: Vec<f64> = lines.iter().map(|(l, _)| l.frequency_hz).collect();
    let receptance: Vec<_> = lines.iter().map(|(l, _)| l.value / frf.quantity.from_receptance(omega_rad_s(l.frequency_hz))).collect();
    let component_sd: Option<Vec<f64>> = lines.iter().map(|(_, sd)| *sd).collect();
    let curve = FrfCurve {
        frequency_hz: &frequency_hz,
        receptance: &receptance,
        component_sd: component_sd.as_deref(),
        omega_power: frf.quantity.power(),
    };
    measurement::modal::fit_curve(&curve, options)
}

/// Names each FRF by its position, its record or its file. Record, channel and number are added if the names are not unique otherwise.
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

/// Formats the regular modes as the mode table of a measurement set: position, mode number, frequency (Hz), amplitude (unit of the FRFs).
fn modes_csv(set: &MeasurementSet, named: &[NamedFrf<'_>], document: &PeaksDocument) -> String {
    let mut text = String::from("position,order,frequency_hz,amplitude\n");
    for n in named.iter().filter(|n| n.frf.position.is_some()) {
        let position = n.frf.position.map_or("", |p| set.positions[p].name.as_str());
        for mode in document.modes.iter().filter(|m| m.regular) {
            if let Some(peak) = mode.records.get(&n.name) {
                let _ = writeln!(text, "{position},{},{},{:e}", mode.order, peak.frequency_hz, peak.amplitude);
            }
        }
    }
    text
}
