//! A measurement set: a folder with `manifest.toml`, read and checked.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use file_access::{MOST_TABLE_BYTES, MOST_TEXT_BYTES, is_inside, is_physical, read_file};

use super::embedded::embedded_file;
use super::folder::{Content, OpenFolder};
use super::frf::{Fault, Frf};
use super::frf_entry::read_frf;
use super::manifest::{ChannelToleranceFile, FrfFile, GainFile, Manifest, parse};
use super::modes::{ModeTable, read_modes};
use super::motion::{MotionRecord, read_motion};
use super::noise_estimate::{estimate_unstated_noise, single_average_warning};
use super::table::Table;
use super::{MeasurementError, Position, Quantity, SourceFile};
use numeric::unit::{Dimension, parse as parse_unit};

/// Factor from the quantity to the recorded amplitudes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gain {
    /// Known factor.
    Known(f64),
    /// One positive factor of the set, estimated with the parameters.
    Unknown,
}

impl Default for Gain {
    /// Amplitudes as recorded.
    fn default() -> Self {
        Gain::Known(1.0)
    }
}

/// One published prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedRow {
    /// Fitted positions.
    pub fit_positions: Vec<String>,
    /// Predicted position.
    pub position: String,
    /// Order.
    pub order: u32,
    /// Predicted natural frequency (Hz).
    pub predicted_hz: f64,
}

/// Published predictions and parameters for a set.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Published {
    /// All predictions.
    pub rows: Vec<PublishedRow>,
    /// Printed values by parameter id, each with the fitted positions.
    pub parameters: Vec<(Vec<String>, BTreeMap<String, f64>)>,
}

impl Published {
    /// Returns the published frequency (Hz) of an order at a position, predicted by a fit to `fit_positions`.
    pub fn predicted_hz(&self, fit_positions: &[String], position: &str, order: u32) -> Option<f64> {
        let same = |r: &&PublishedRow| {
            are_same(&r.fit_positions, fit_positions) && r.position == position && r.order == order
        };
        self.rows.iter().find(same).map(|r| r.predicted_hz)
    }

    /// Returns the printed values by parameter id of a fit to `fit_positions`.
    pub fn parameters(&self, fit_positions: &[String]) -> Option<&BTreeMap<String, f64>> {
        self.parameters.iter().find(|(fit, _)| are_same(fit, fit_positions)).map(|(_, values)| values)
    }
}

/// Whether two lists hold the same names.
fn are_same(a: &[String], b: &[String]) -> bool {
    a.len() == b.len() && a.iter().all(|name| b.contains(name))
}

/// Standard deviations of channel gains, channel delays and nut positions of a hammer test.
///
/// # Source  defaults: calibration of force and acceleration sensors, synchronism of analyser channels,
///   reading of a scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelTolerance {
    /// Gain of each channel: of ln(gain) (1).
    pub gain: f64,
    /// Delay of each channel against the force (s).
    pub delay_s: f64,
    /// Nut positions (m).
    pub nut_m: f64,
}

impl Default for ChannelTolerance {
    fn default() -> Self {
        ChannelTolerance { gain: 0.004, delay_s: 2e-6, nut_m: 5e-4 }
    }
}

/// Observations of one machine.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeasurementSet {
    /// Folder of the set.
    pub path: String,
    /// Title.
    pub title: String,
    /// Quantity of the amplitudes of `modes`.
    pub quantity: Option<Quantity>,
    /// Gain of the set.
    pub gain: Gain,
    /// Response point of `modes`.
    pub response: Option<String>,
    /// Excitation point of `modes`.
    pub excitation: Option<String>,
    /// Positions.
    pub positions: Vec<Position>,
    /// Modes, where observed.
    pub modes: Option<ModeTable>,
    /// FRFs.
    pub frfs: Vec<Frf>,
    /// Time records.
    pub motions: Vec<MotionRecord>,
    /// Names of positions or records to fit, where the manifest lists them.
    pub split: Option<Vec<String>>,
    /// Standard deviations of channels and nut positions.
    pub tolerance: ChannelTolerance,
    /// Published predictions, where there are any.
    pub published: Published,
    /// Files read.
    pub files: Vec<SourceFile>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

impl MeasurementSet {
    /// Returns the nut positions from the left bearing (m), of all positions that state one.
    pub fn nuts_m(&self) -> Vec<f64> {
        self.positions.iter().filter_map(|p| p.nut_m).collect()
    }

    /// Returns a set without observations and positions, for machines without measurements.
    pub fn none() -> Self {
        MeasurementSet { path: "no measurement set".into(), ..MeasurementSet::default() }
    }
}

/// Returns the tolerances of the measuring chain: those stated, checked against their range, else the
/// defaults.
fn tolerance(path: &str, file: &ChannelToleranceFile) -> Result<ChannelTolerance, MeasurementError> {
    let default = ChannelTolerance::default();
    let known = |key: &str, stated: Option<f64>, default: f64, largest: f64| match stated {
        Some(sd) if !(0.0..=largest).contains(&sd) => {
            let remedy = format!(
                "write a standard deviation from 0 to {largest} (default {default:e}), or leave it out"
            );
            Err(MeasurementError::key(path, format!("tolerance.{key}"), format!("is {sd}; {remedy}")))
        }
        stated => Ok(stated.unwrap_or(default)),
    };
    Ok(ChannelTolerance {
        gain: known("gain", file.gain, default.gain, 0.3)?,
        delay_s: known("delay_s", file.delay_s, default.delay_s, 1e-3)?,
        nut_m: known("nut_m", file.nut_m, default.nut_m, 0.01)?,
    })
}

/// Reads a measurement set from a folder, or the embedded bench where there is no folder of that name.
///
/// # Errors  a file is missing or unreadable or lies outside the folder, a key is unknown or missing, a cell
///   is not a number, a position appears
/// twice, there is no observation.
pub fn read_set(path: &str) -> Result<MeasurementSet, MeasurementError> {
    read_set_from(path, false)
}

/// Reads a set as [`read_set`]; with `allow_outside` its files may lie outside its folder.
///
/// # Errors  as [`read_set`].
pub fn read_set_from(path: &str, allow_outside: bool) -> Result<MeasurementSet, MeasurementError> {
    let folder = Path::new(path);
    read_set_with(path, |file| {
        if !allow_outside && file != MANIFEST && !is_inside(folder, file) {
            return Err(io::Error::other(
                "lies outside the folder of its manifest; copy it into the folder, or allow files outside",
            ));
        }
        let most_bytes = if file == MANIFEST { MOST_TEXT_BYTES } else { MOST_TABLE_BYTES };
        match read_file(&folder.join(file), most_bytes) {
            Err(fault) if !folder.exists() => {
                embedded_file(path, file).map(|text| text.as_bytes().to_vec()).ok_or(fault.into())
            }
            read => Ok(read?),
        }
    })
}

/// Name of the file that lists the others of a set.
pub(crate) const MANIFEST: &str = "manifest.toml";

/// Reads a set as [`read_set`]; `read` returns the content of a file by its name in the manifest.
///
/// # Errors  as [`read_set`].
pub fn read_set_with(
    path: &str,
    read: impl Fn(&str) -> io::Result<Vec<u8>>,
) -> Result<MeasurementSet, MeasurementError> {
    Ok(read_set_of(path, |file| read(file).map(Content::Bytes))?.with_noise())
}

/// A set in which FRFs that do not state their noise have none yet: estimating it takes longer than reading.
#[derive(Debug, Clone, PartialEq)]
pub struct SetWithoutNoise(MeasurementSet);

impl SetWithoutNoise {
    /// Estimates the noise that FRFs do not state.
    pub fn with_noise(self) -> MeasurementSet {
        let mut set = self.0;
        estimate_unstated_noise(&mut set.frfs);
        set
    }
}

/// Reads a set as [`read_set`]; `read` returns what a file holds by its name in the manifest.
pub(super) fn read_set_of(
    path: &str,
    mut read: impl FnMut(&str) -> io::Result<Content>,
) -> Result<SetWithoutNoise, MeasurementError> {
    let mut folder = OpenFolder { path, read: &mut read, files: Vec::new() };
    let manifest_path = folder.name(MANIFEST);
    let fault = |fault: String| MeasurementError::file(&manifest_path, fault);
    let at_key = |key: &str, fault: String| MeasurementError::key(&manifest_path, key, fault);
    let text = folder.text(MANIFEST)?;
    let manifest = parse(&manifest_path, &text)?;
    let positions = positions(&manifest_path, &manifest)?;
    let mut warnings = Vec::new();
    let gain = gain(&manifest_path, &manifest, &mut warnings)?;
    if let Some(step) = manifest.frequency_resolution_hz.filter(|s| !(*s > 0.0 && s.is_finite())) {
        return Err(at_key(
            "frequency_resolution_hz",
            format!("is {step}; write a number above 0, or leave it out"),
        ));
    }
    if let Some(least) = manifest.least_prominence.filter(|p| !(*p > 1.0 && p.is_finite())) {
        let remedy = "write the smallest prominence of a read peak, above 1 (2: twice the adjacent valley), or leave it out";
        return Err(at_key("least_prominence", format!("is {least}; {remedy}")));
    }
    let tolerance = tolerance(&manifest_path, &manifest.tolerance)?;
    let modes = read_mode_table(&mut folder, &manifest, &positions)?;
    let (mut frfs, mut singles) = (Vec::new(), Vec::new());
    for (at, entry) in manifest.frf.iter().enumerate() {
        if manifest.frf[..at].iter().any(|other| other.file == entry.file) {
            return Err(fault(format!("[[frf]] {} is listed twice; it would count twice", entry.file)));
        }
        let (frf, is_single) = read_frf(&mut folder, &manifest, entry, &positions)?;
        if is_single {
            singles.push(frf.source.clone());
        }
        frfs.push(frf);
    }
    warnings.extend(single_average_warning(&singles));
    warnings.extend(length_warning(&manifest_path, &frfs));
    if modes.is_none() && frfs.is_empty() && manifest.motion.is_empty() {
        return Err(fault("holds no observation at all; write modes = \"…\", [[frf]] or [[motion]]".into()));
    }
    let mut motions: Vec<MotionRecord> = Vec::new();
    for entry in &manifest.motion {
        if motions.iter().any(|m| m.name == entry.name) {
            return Err(fault(format!(
                "[[motion]] «{}» appears twice; give each record its own name",
                entry.name
            )));
        }
        let text = folder.text(&entry.file)?;
        motions.push(read_motion(&folder.name(&entry.file), &entry.name, &text)?);
    }
    let mut published = Published::default();
    if let Some(file) = &manifest.published {
        let text = folder.text(file)?;
        published = read_published(&folder.name(file), &text)?;
    }
    for entry in manifest.published_parameters {
        let key = "published_parameters.fit";
        if let Some(unknown) = entry.fit.iter().find(|name| !positions.iter().any(|p| p.name == **name)) {
            return Err(at_key(key, format!("no position is called «{unknown}»")));
        }
        published.parameters.push((entry.fit, entry.values));
    }
    let split = manifest.split.map(|s| s.fit);
    let is_known = |n: &String| {
        positions.iter().any(|p| p.name == *n)
            || frfs.iter().any(|f: &Frf| f.record.as_ref() == Some(n))
            || manifest.motion.iter().any(|m| m.name == *n)
    };
    if let Some(unknown) = split.iter().flatten().find(|n| !is_known(n)) {
        return Err(at_key("split.fit", format!("no position or record is called «{unknown}»")));
    }
    Ok(SetWithoutNoise(MeasurementSet {
        path: path.into(),
        title: manifest.title.split_whitespace().collect::<Vec<_>>().join(" "),
        quantity: manifest.quantity,
        gain,
        response: manifest.response,
        excitation: manifest.excitation,
        positions,
        modes,
        frfs,
        motions,
        split,
        tolerance,
        published,
        files: folder.files,
        warnings,
    }))
}

/// Reads the table of modes; `None` where the set has none.
fn read_mode_table(
    folder: &mut OpenFolder<'_>,
    manifest: &Manifest,
    positions: &[Position],
) -> Result<Option<ModeTable>, MeasurementError> {
    let Some(file) = &manifest.modes else { return Ok(None) };
    let manifest_path = folder.name(MANIFEST);
    let fault = |fault: &str| MeasurementError::file(&manifest_path, fault);
    let text = folder.text(file)?;
    let table = read_modes(&folder.name(file), &text, positions)?;
    if table.iter().flatten().any(|m| m.amplitude.is_some()) && manifest.quantity.is_none() {
        return Err(fault("has no `quantity`; write one of receptance, mobility, accelerance"));
    }
    if manifest.response.is_none() || manifest.excitation.is_none() {
        return Err(fault(
            "has modes but no `response` and `excitation`; write the points of the machine they were measured at",
        ));
    }
    let (resolution_hz, least_prominence) = (manifest.frequency_resolution_hz, manifest.least_prominence);
    Ok(Some(ModeTable { positions: table, resolution_hz, least_prominence }))
}

/// Greatest distance of a nut from the left end of its screw (m).
const LONGEST_M: f64 = 1e3;

fn positions(path: &str, manifest: &Manifest) -> Result<Vec<Position>, MeasurementError> {
    let mut positions: Vec<Position> = Vec::new();
    for p in &manifest.position {
        if positions.iter().any(|q| q.name == p.name) {
            return Err(MeasurementError::file(
                path,
                format!("position «{}» appears twice; give each position its own name", p.name),
            ));
        }
        if let Some(nut_m) = p.nut_m.filter(|x| !(x.abs() <= LONGEST_M)) {
            let fault = format!("nut_m is {nut_m:e}; write a distance in m, at most {LONGEST_M} m");
            return Err(MeasurementError::key(path, format!("position «{}»", p.name), fault));
        }
        positions.push(Position { name: p.name.clone(), nut_m: p.nut_m });
    }
    Ok(positions)
}

/// Returns the gain of a set; unknown where the excitation is neither a force nor a torque.
fn gain(
    manifest_path: &str,
    manifest: &Manifest,
    warnings: &mut Vec<String>,
) -> Result<Gain, MeasurementError> {
    let at_key = |key: &str, fault: String| MeasurementError::key(manifest_path, key, fault);
    let gain = match manifest.gain {
        None => Gain::Known(1.0),
        Some(GainFile::Number(g)) if g > 0.0 && is_physical(g) => Gain::Known(g),
        Some(GainFile::Number(g)) => {
            return Err(at_key("gain", format!("is {g}; write a number above 0, or \"unknown\"")));
        }
        Some(GainFile::Word(_)) => Gain::Unknown,
    };
    Ok(match manifest.excitation_unit.as_deref() {
        None | Some("N" | "N*m") => gain,
        // Position over command: both in one unit.
        Some("m" | "rad") if is_commanded(manifest) => gain,
        Some(unit) if is_newton(unit).map_err(|fault| at_key("excitation_unit", fault))? => gain,
        Some(unit) => {
            if let (Some(GainFile::Number(g)), unit) = (&manifest.gain, unit) {
                warnings.push(format!(
                    "{manifest_path}: gain = {g} is ignored: with an excitation in {unit} the gain is unknown and is estimated"
                ));
            }
            Gain::Unknown
        }
    })
}

/// Excitation that is the command of a position loop.
pub(crate) const COMMAND: &str = "command";

/// Whether every excitation of a set is the command of the position loop.
fn is_commanded(manifest: &Manifest) -> bool {
    let own = |frf: &FrfFile| {
        frf.excitation.as_ref().or(manifest.excitation.as_ref()).is_some_and(|name| name == COMMAND)
    };
    !manifest.frf.is_empty() && manifest.frf.iter().all(own)
}

/// Warns of a set with so many lines that fits take long: the model is evaluated at each of them.
fn length_warning(path: &str, frfs: &[Frf]) -> Option<String> {
    const MANY: usize = 300_000;
    let lines: usize = frfs.iter().map(|frf| frf.lines.len()).sum();
    // A core fits 3,000 lines of the bench in 12 s, tolerances and intervals included.
    let hours = 4e-3 * lines as f64 / 3600.0;
    let time = if hours < 1.0 { format!("{:.0} min", 60.0 * hours) } else { format!("{hours:.1} h") };
    let advice = "export with a coarser resolution, restrict the band, or fit without tolerances";
    (lines > MANY).then(|| {
        format!(
            "{path}: the FRFs have {lines} lines together; a fit takes about {time} on one core; {advice}"
        )
    })
}

/// Whether a unit of the excitation is N or N·m under another spelling; false where it is no unit of force or
/// torque, such as A.
fn is_newton(label: &str) -> Result<bool, Fault> {
    let unit = parse_unit(label)
        .map_err(|fault| format!("{fault}; write N, N*m, or the unit of a signal, such as A"))?;
    if ![Dimension::FORCE, Dimension::TORQUE].contains(&unit.dimension) {
        return Ok(false);
    }
    if (unit.to_si() - 1.0).abs() > 1e-12 {
        return Err(format!(
            "is {label}; the values of a set are in SI units: multiply them by {} and write N or N*m",
            unit.to_si().recip()
        ));
    }
    Ok(true)
}

fn read_published(path: &str, text: &str) -> Result<Published, MeasurementError> {
    let table = Table::read(path, text, &["fit_positions", "position", "order", "predicted_hz"], &[])?;
    let mut rows = Vec::new();
    for row in table.rows() {
        let row = row?;
        rows.push(PublishedRow {
            fit_positions: row.text("fit_positions")?.split('+').map(str::to_string).collect(),
            position: row.text("position")?.to_string(),
            order: row.text("order")?.parse().map_err(|_| row.fault("order is not a whole number".into()))?,
            predicted_hz: row.number("predicted_hz")?,
        });
    }
    Ok(Published { rows, parameters: Vec::new() })
}
