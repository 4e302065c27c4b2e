//! Measurement sets as universal files.

use crate::{StudyError, StudyResult};
use measurement::{Frf, Gain, MeasurementSet, Quantity};
use universal_files::{
    Abscissa, ByteOrder, Encoding, FileHeader, NodeLocation, RecordAxis, Units, UniversalRecord,
    UniversalWriter, WriteError, data_type,
};

/// A measurement set as a universal file.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportedSet {
    /// Content of the file.
    pub bytes: Vec<u8>,
    /// Number of FRFs.
    pub frfs: usize,
    /// What the file cannot hold.
    pub notes: Vec<String>,
}

/// Formats the FRFs of a set as a universal file, in dataset 58b (binary) or 58 (text). A known gain is divided
/// out, so that the values are those of the structure.
///
/// # Errors  the set holds no FRF, or one that a universal file cannot hold.
pub fn export(set: &MeasurementSet, binary: bool) -> StudyResult<ExportedSet> {
    if set.frfs.is_empty() {
        return Err(StudyError::input(&set.path, "the set has no FRF to export"));
    }
    let mut points: Vec<String> = Vec::new();
    let mut node = |name: &str| match points.iter().position(|p| p == name) {
        Some(at) => at as i64 + 1,
        None => {
            points.push(name.to_string());
            points.len() as i64
        }
    };
    let mut writer = UniversalWriter::new(Vec::new());
    let fault = |e: WriteError| StudyError::input(&set.path, e.to_string());
    writer.header(&FileHeader { model_name: set.title.clone(), ..FileHeader::default() }).map_err(fault)?;
    writer.units(&Units::si()).map_err(fault)?;
    let gain = match set.gain {
        Gain::Known(gain) => gain,
        Gain::Unknown => 1.0,
    };
    let encoding = if binary { Encoding::Binary(ByteOrder::Little) } else { Encoding::Ascii };
    for frf in &set.frfs {
        let position = frf.position.map(|p| set.positions[p].name.clone());
        let (response, excitation) = (node(&frf.response), node(&frf.excitation));
        let record = record((frf, gain), position.as_deref(), response, excitation);
        writer.record(&record, encoding).map_err(fault)?;
    }
    let bytes = writer.finish().map_err(fault)?;
    let has_noise = set.frfs.iter().any(|f| f.noise_source().is_stated());
    let left_out = "coherence and relative_sd have no field in a universal FRF record and are not written; keep the measurement set, too";
    let has_window = set.frfs.iter().any(|f| f.condition.window_per_s > 0.0);
    let unstated = "an exponential window has no field in a universal FRF record; state exponential_window_s again where the file is imported";
    let uncalibrated = "the gain of the set is unknown, and a universal FRF record cannot say so: the values are not calibrated; state gain = \"unknown\" again where the file is imported";
    let divided =
        format!("the values are divided by the gain of the set, {gain}: those of the file have a gain of 1");
    let notes = [
        (has_noise, left_out),
        (has_window, unstated),
        (set.gain == Gain::Unknown, uncalibrated),
        (gain != 1.0, &divided),
    ];
    let notes = notes.into_iter().filter(|(applies, _)| *applies).map(|(_, note)| note.to_string());
    Ok(ExportedSet { bytes, frfs: set.frfs.len(), notes: notes.collect() })
}

fn record(
    (frf, gain): (&Frf, f64),
    position: Option<&str>,
    response: i64,
    excitation: i64,
) -> UniversalRecord {
    let (code, label, unit) = match frf.quantity {
        Quantity::Receptance => (data_type::DISPLACEMENT, "Displacement", "m"),
        Quantity::Mobility => (data_type::VELOCITY, "Velocity", "m/s"),
        Quantity::Accelerance => (data_type::ACCELERATION, "Acceleration", "m/s^2"),
    };
    let location =
        |name: &str, node: i64| NodeLocation { entity: name.chars().take(10).collect(), node, direction: 1 };
    let frequency = Abscissa::Uneven(frf.lines.iter().map(|l| l.frequency_hz).collect());
    let values = frf.lines.iter().map(|line| frf.recorded(line) / gain).collect();
    let numerator = RecordAxis::new(code, label, unit);
    let mut record = UniversalRecord::frequency_response(
        location(&frf.response, response),
        location(&frf.excitation, excitation),
        numerator,
        frequency,
        values,
    );
    record.header.id_lines[0] = format!("{} / {}", frf.response, frf.excitation);
    if let Some(position) = position {
        record.header.id_lines[3] = format!("position {position}");
    }
    record
}
