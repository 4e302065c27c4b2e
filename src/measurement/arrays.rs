//! Measurement sets from arrays in memory, with the same checks as sets from files.

use std::collections::BTreeMap;

use num_complex::Complex64;
use numeric::digest::digest_of;

use super::frf::{FrfLine, FrfNoise, SortedLines};
use super::noise_estimate::{drop_coherence_of_one, estimate_unstated_noise, single_average_warning};
use super::{
    ChannelTolerance, Condition, DriveEffort, Frf, Gain, MeasurementError, MeasurementSet, MotionRecord,
    Position, Quantity, SourceFile,
};

/// An FRF as arrays of equal length.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrfArrays {
    /// Name of its position; absent where the machine has no positions.
    pub position: Option<String>,
    /// Name of the record, where a position has several.
    pub record: Option<String>,
    /// Quantity, where it is not that of the set.
    pub quantity: Option<Quantity>,
    /// Number of averages, where it is not that of the set.
    pub averages: Option<u32>,
    /// Operating condition.
    pub condition: Condition,
    /// Response point, where it is not that of the set.
    pub response: Option<String>,
    /// Excitation point, where it is not that of the set.
    pub excitation: Option<String>,
    /// Frequencies (Hz), rising.
    pub frequency_hz: Vec<f64>,
    /// H = response / force, e^{+iωt}, in the quantity of the set.
    pub value: Vec<Complex64>,
    /// Coherence γ² (1), which needs the number of averages of the set.
    pub coherence: Option<Vec<f64>>,
    /// Standard deviation of the complex mean over |H| (1).
    pub relative_sd: Option<Vec<f64>>,
}

/// A motion record as arrays of equal length.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionArrays {
    /// Name of the record.
    pub name: String,
    /// Times (s), evenly spaced.
    pub time_s: Vec<f64>,
    /// Commanded position (m).
    pub command_m: Vec<f64>,
    /// Measured position (m).
    pub position_m: Vec<f64>,
    /// Drive force (N) or motor torque (N·m).
    pub load: DriveEffort,
    /// Other channels by column name.
    pub others: BTreeMap<String, Vec<f64>>,
}

/// A measurement set as arrays.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SetArrays {
    /// Title.
    pub title: String,
    /// Quantity of the FRFs.
    pub quantity: Option<Quantity>,
    /// Response point of the FRFs.
    pub response: Option<String>,
    /// Excitation point of the FRFs.
    pub excitation: Option<String>,
    /// Number of averages of each FRF.
    pub averages: Option<u32>,
    /// Factor from prediction to record (1), known or to be estimated.
    pub gain: Gain,
    /// Standard deviations of channels and nut positions.
    pub tolerance: ChannelTolerance,
    /// Names of the positions or records to fit, where no others are named.
    pub split: Option<Vec<String>>,
    /// Nut positions from the left bearing (m) by position; absent where a position has none.
    pub nut_m: BTreeMap<String, Option<f64>>,
    /// FRFs.
    pub frfs: Vec<FrfArrays>,
    /// Motion records.
    pub motions: Vec<MotionArrays>,
}

/// Checks that an array has as many entries as another.
fn same_length(
    source: &str,
    (key, length): (&str, usize),
    (of, wanted): (&str, usize),
) -> Result<(), MeasurementError> {
    if length == wanted {
        return Ok(());
    }
    Err(MeasurementError::file(
        source,
        format!("{key} has {length} entries, {of} has {wanted}; give arrays of equal length"),
    ))
}

/// Warns of lines that state no FRF: at 0 Hz, or with the value 0.
fn empty_lines_warning(frf: &Frf) -> Option<String> {
    let is_empty = |line: &&FrfLine| line.frequency_hz <= 0.0 || line.value.norm() == 0.0;
    let count = frf.rejected.iter().filter(is_empty).count();
    let all = frf.lines.len() + frf.rejected.len();
    (count > 0).then(|| {
        format!("{}: {count} of {all} lines are not used: their frequency or their value is 0", frf.source)
    })
}

/// Checks that all numbers are finite.
fn finite(source: &str, key: &str, numbers: impl IntoIterator<Item = f64>) -> Result<(), MeasurementError> {
    match numbers.into_iter().enumerate().find(|(_, x)| !x.is_finite()) {
        None => Ok(()),
        Some((at, x)) => {
            Err(MeasurementError::file(source, format!("{key}[{at}] is {x}; give finite numbers")))
        }
    }
}

impl FrfArrays {
    fn source(&self, at: usize) -> String {
        let name =
            [&self.position, &self.record].into_iter().flatten().cloned().collect::<Vec<_>>().join(" ");
        if name.is_empty() { format!("frfs[{at}]") } else { format!("frfs[{at}] ({name})") }
    }

    /// Returns the FRF, and whether its coherence is 1 at every line.
    fn read(
        &self,
        source: &str,
        set: &SetArrays,
        positions: &[Position],
    ) -> Result<(Frf, bool), MeasurementError> {
        let fault = |text: String| MeasurementError::file(source, text);
        let of = ("frequency_hz", self.frequency_hz.len());
        same_length(source, ("value", self.value.len()), of)?;
        for (key, array) in [("coherence", &self.coherence), ("relative_sd", &self.relative_sd)] {
            if let Some(array) = array {
                same_length(source, (key, array.len()), of)?;
                finite(source, key, array.iter().copied())?;
            }
        }
        finite(source, "frequency_hz", self.frequency_hz.iter().copied())?;
        finite(source, "value", self.value.iter().flat_map(|h| [h.re, h.im]))?;
        let averages = self.averages.or(set.averages);
        let mut sorted = SortedLines::default();
        for (at, (frequency_hz, value)) in self.frequency_hz.iter().zip(&self.value).enumerate() {
            let cell = |array: &Option<Vec<f64>>| array.as_ref().map(|array| array[at]);
            let added = sorted.add(*frequency_hz, *value, cell(&self.coherence), cell(&self.relative_sd));
            added.map_err(|text| fault(format!("entry {at}: {text}")))?;
        }
        let (mut lines, rejected) = sorted.finish(self.coherence.is_some()).map_err(fault)?;
        let is_single = drop_coherence_of_one(&mut lines);
        let has_coherence = lines.iter().any(|line| matches!(line.noise, Some(FrfNoise::Coherence(_))));
        if has_coherence && averages.is_none_or(|averages| averages < 2) {
            return Err(fault(
                "has a coherence but no averages; state how many records were averaged, two or more".into(),
            ));
        }
        let point = |own: &Option<String>, of_set: &Option<String>, key: &str| {
            let name = own.clone().or_else(|| of_set.clone());
            name.ok_or_else(|| fault(format!("has no {key}, nor has the set; name the point of the machine")))
        };
        let frf = Frf {
            position: self.position.as_ref().and_then(|name| positions.iter().position(|p| p.name == *name)),
            record: self.record.clone(),
            response: point(&self.response, &set.response, "response")?,
            excitation: point(&self.excitation, &set.excitation, "excitation")?,
            quantity: self.quantity.or(set.quantity).ok_or_else(|| {
                fault("has no quantity, nor has the set; state receptance, mobility or accelerance".into())
            })?,
            condition: self.condition,
            averages,
            source: source.into(),
            lines,
            rejected,
        };
        Ok((frf, is_single))
    }
}

impl MotionArrays {
    fn read(&self, source: &str) -> Result<MotionRecord, MeasurementError> {
        let of = ("time_s", self.time_s.len());
        let own = [
            ("command_m", &self.command_m[..]),
            ("position_m", &self.position_m),
            (self.load.column(), self.load.samples()),
        ];
        let others = self.others.iter().map(|(name, samples)| (name.as_str(), &samples[..]));
        for (key, samples) in own.into_iter().chain(others).chain([("time_s", &self.time_s[..])]) {
            same_length(source, (key, samples.len()), of)?;
            finite(source, key, samples.iter().copied())?;
        }
        let record = MotionRecord {
            name: self.name.clone(),
            source: source.into(),
            step_s: 0.0,
            time_s: self.time_s.clone(),
            is_angle: false,
            command_m: self.command_m.clone(),
            position_m: self.position_m.clone(),
            load: self.load.clone(),
            others: self.others.clone(),
        };
        record.checked(&(1..=self.time_s.len() as u64).collect::<Vec<u64>>())
    }
}

impl MeasurementSet {
    /// Makes a set from arrays in memory.
    ///
    /// # Errors  there is no observation; arrays of one record differ in length or are not finite; a key is
    ///   missing; frequencies or times are not in
    /// order. The message names the record and the key.
    pub fn from_arrays(arrays: &SetArrays) -> Result<Self, MeasurementError> {
        let path = if arrays.title.is_empty() { "the measurement set" } else { &arrays.title };
        let fault = |text: String| MeasurementError::file(path, text);
        if arrays.frfs.is_empty() && arrays.motions.is_empty() {
            return Err(fault("holds no observation at all; give frfs or motions".into()));
        }
        if let Some((name, nut_m)) =
            arrays.nut_m.iter().find(|(_, nut_m)| nut_m.is_some_and(|x| !x.is_finite()))
        {
            return Err(fault(format!(
                "nut_m of {name} is {}; give a distance in m",
                nut_m.unwrap_or(f64::NAN)
            )));
        }
        let mut positions: Vec<Position> =
            arrays.nut_m.iter().map(|(name, nut_m)| Position { name: name.clone(), nut_m: *nut_m }).collect();
        for name in arrays.frfs.iter().filter_map(|frf| frf.position.as_ref()) {
            if !positions.iter().any(|p| p.name == *name) {
                if !arrays.nut_m.is_empty() {
                    let known: Vec<&str> = arrays.nut_m.keys().map(String::as_str).collect();
                    return Err(fault(format!(
                        "nut_m has no position «{name}»; it has {}",
                        known.join(", ")
                    )));
                }
                positions.push(Position { name: name.clone(), nut_m: None });
            }
        }
        let (mut frfs, mut motions, mut singles) = (Vec::new(), Vec::new(), Vec::new());
        for (at, frf) in arrays.frfs.iter().enumerate() {
            let source = frf.source(at);
            let (frf, is_single) = frf.read(&source, arrays, &positions)?;
            if is_single {
                singles.push(source);
            }
            frfs.push(frf);
        }
        let empty: Vec<String> = frfs.iter().filter_map(empty_lines_warning).collect();
        estimate_unstated_noise(&mut frfs);
        for motion in &arrays.motions {
            if motion.name.is_empty() {
                return Err(fault("a motion record has no name; give each record its own".into()));
            }
            if motions.iter().any(|m: &MotionRecord| m.name == motion.name) {
                return Err(fault(format!(
                    "motion record «{}» appears twice; give each record its own name",
                    motion.name
                )));
            }
            let source = format!("motion record {}", motion.name);
            motions.push(motion.read(&source)?);
        }
        let digest = digest_of(arrays);
        Ok(MeasurementSet {
            // Results name their set by its path: other arrays are another set.
            path: format!("{path} ({})", &digest[..8]),
            title: arrays.title.clone(),
            quantity: arrays.quantity,
            gain: arrays.gain,
            response: arrays.response.clone(),
            excitation: arrays.excitation.clone(),
            positions,
            frfs,
            motions,
            tolerance: arrays.tolerance,
            split: arrays.split.clone(),
            warnings: single_average_warning(&singles).into_iter().chain(empty).collect(),
            // In place of files: a digest of everything that was given.
            files: vec![SourceFile::new(format!("arrays of {path}"), || digest.into_bytes())],
            ..MeasurementSet::none()
        })
    }
}
