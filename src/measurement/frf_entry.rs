//! An FRF of a measurement set: its entry in the manifest, and its file.

use super::folder::OpenFolder;
use super::frf::{Condition, Frf, FrfNoise};
use super::manifest::{FrfFile, Manifest};
use super::noise_estimate::drop_coherence_of_one;
use super::sensing::Sensing;
use super::{MeasurementError, Position};

/// Reads an FRF. Returns also whether its coherence is 1 at every line.
pub(super) fn read_frf(
    folder: &mut OpenFolder<'_>,
    manifest: &Manifest,
    entry: &FrfFile,
    positions: &[Position],
) -> Result<(Frf, bool), MeasurementError> {
    let manifest_path = folder.name("manifest.toml");
    let fault = |text: String| MeasurementError::key(&manifest_path, format!("[[frf]] {}", entry.file), text);
    let (mut lines, mut rejected) = folder.lines(&entry.file)?;
    let is_single = drop_coherence_of_one(&mut lines);
    let position = match &entry.position {
        Some(name) => Some(positions.iter().position(|p| p.name == *name).ok_or_else(|| {
            let known: Vec<&str> = positions.iter().map(|p| p.name.as_str()).collect();
            fault(format!("no position is called «{name}»; there are {}", known.join(", ")))
        })?),
        None => None,
    };
    let named = |own: &Option<String>, set: &Option<String>, key: &str| {
        own.clone()
            .or_else(|| set.clone())
            .ok_or_else(|| fault(format!("has no `{key}`, nor has the set; write the point's name")))
    };
    for (key, direction) in [
        ("response_direction", &entry.response_direction),
        ("excitation_direction", &entry.excitation_direction),
    ] {
        let is_direction = |name: &str| {
            name.strip_prefix(['+', '-'])
                .is_some_and(|axis| ["X", "Y", "Z", "RX", "RY", "RZ"].contains(&axis))
        };
        if let Some(name) = direction.as_ref().filter(|name| !is_direction(name)) {
            return Err(fault(format!("{key}: is «{name}»; write a sign and an axis, as in +Z or -RX")));
        }
    }
    let averages = entry.averages.or(manifest.averages);
    if averages == Some(0) {
        return Err(fault("averages: is 0; write a whole number from 1".into()));
    }
    if averages == Some(1) && lines.iter().any(|l| matches!(l.noise, Some(FrfNoise::Coherence(_)))) {
        return Err(fault("averages: is 1, but the coherence of a single record is always 1; leave the column out, or average".into()));
    }
    if averages.is_none() && lines.iter().any(|l| matches!(l.noise, Some(FrfNoise::Coherence(_)))) {
        return Err(fault("has a coherence but no `averages`; write how many records were averaged".into()));
    }
    for (key, number) in [
        ("force_n", entry.force_n),
        ("speed_m_s", entry.speed_m_s),
        ("acceleration_m_s2", entry.acceleration_m_s2),
    ] {
        if let Some(x) = number.filter(|x| !x.is_finite()) {
            return Err(fault(format!("{key}: is {x}; write a finite number")));
        }
    }
    let quantity = entry.quantity.or(manifest.quantity);
    let quantity = quantity.ok_or_else(|| {
        fault("has no `quantity`, nor has the set; write one of receptance, mobility, accelerance".into())
    })?;
    let sensing = Sensing::of(manifest, entry).map_err(fault)?;
    for line in lines.iter_mut().chain(&mut rejected) {
        line.value *= sensing.correction(quantity, line.frequency_hz);
    }
    let condition = Condition {
        force_level_n: entry.force_n,
        velocity_m_s: entry.speed_m_s,
        acceleration_m_s2: entry.acceleration_m_s2,
        window_per_s: sensing.window_per_s,
    };
    let frf = Frf {
        position,
        record: entry.record.clone(),
        response: named(&entry.response, &manifest.response, "response")?,
        excitation: named(&entry.excitation, &manifest.excitation, "excitation")?,
        quantity,
        condition,
        averages,
        source: folder.name(&entry.file),
        lines,
        rejected,
    };
    Ok((frf, is_single))
}
