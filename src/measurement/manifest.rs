//! Keys of `manifest.toml`.

use std::collections::BTreeMap;

use file_access::{shortened, unfilled};
use schemars::JsonSchema;
use serde::Deserialize;

use super::{MeasurementError, Quantity};

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Manifest {
    pub title: String,
    pub quantity: Option<Quantity>,
    pub gain: Option<GainFile>,
    pub excitation_unit: Option<String>,
    pub response: Option<String>,
    pub excitation: Option<String>,
    pub averages: Option<u32>,
    /// Time constant τ of an exponential window e^(−t/τ) on the response (s); 0: none.
    pub exponential_window_s: Option<f64>,
    /// Natural frequency of the sensor on its mount (Hz), and its damping ratio: both or none.
    pub mount_resonance_hz: Option<f64>,
    pub mount_damping_ratio: Option<f64>,
    pub modes: Option<String>,
    pub frequency_resolution_hz: Option<f64>,
    pub least_prominence: Option<f64>,
    pub published: Option<String>,
    /// Values of parameters that the publication of the data prints, for comparison.
    #[serde(default)]
    pub published_parameters: Vec<PublishedParametersFile>,
    pub split: Option<Split>,
    #[serde(default)]
    pub tolerance: ChannelToleranceFile,
    #[serde(default)]
    pub position: Vec<PositionFile>,
    #[serde(default)]
    pub frf: Vec<FrfFile>,
    #[serde(default)]
    pub motion: Vec<MotionFile>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a number above 0, or \"unknown\"")]
pub(super) enum GainFile {
    Number(f64),
    Word(UnknownWord),
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum UnknownWord {
    Unknown,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PublishedParametersFile {
    /// Fitted positions.
    pub fit: Vec<String>,
    /// Printed values by parameter id.
    pub values: BTreeMap<String, f64>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Split {
    pub fit: Vec<String>,
}

/// Standard deviations of channel gains, channel delays and nut positions; the defaults apply to keys left
/// out.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ChannelToleranceFile {
    /// Gain of each channel, relative; default 0.004.
    pub gain: Option<f64>,
    /// Delay of each channel against the force (s); default 2e-6.
    pub delay_s: Option<f64>,
    /// Nut positions (m); default 5e-4.
    pub nut_m: Option<f64>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PositionFile {
    pub name: String,
    pub nut_m: Option<f64>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FrfFile {
    pub position: Option<String>,
    pub file: String,
    pub response: Option<String>,
    pub excitation: Option<String>,
    pub quantity: Option<Quantity>,
    pub averages: Option<u32>,
    /// Time constant τ of an exponential window e^(−t/τ) on the response (s); 0: none.
    pub exponential_window_s: Option<f64>,
    /// Natural frequency of the sensor on its mount (Hz), and its damping ratio: both or none.
    pub mount_resonance_hz: Option<f64>,
    pub mount_damping_ratio: Option<f64>,
    pub record: Option<String>,
    /// Direction of the sensor in the imported file, such as `+Z`. The signs are applied to the values
    /// already.
    pub response_direction: Option<String>,
    /// Direction of the blow in the imported file.
    pub excitation_direction: Option<String>,
    pub force_n: Option<f64>,
    pub speed_m_s: Option<f64>,
    pub acceleration_m_s2: Option<f64>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MotionFile {
    pub name: String,
    pub file: String,
}

/// Parses the text of a manifest.
pub(super) fn parse(path: &str, text: &str) -> Result<Manifest, MeasurementError> {
    if text.trim().is_empty() {
        return Err(MeasurementError::file(
            path,
            "is empty; write at least title, quantity and modes, [[frf]] or [[motion]]",
        ));
    }
    let open = toml::from_str::<toml::Table>(text).map(|table| unfilled(&table)).unwrap_or_default();
    if !open.is_empty() {
        let fault = format!(
            "{}: NaN, still to be filled in; write a number for each, or remove the key",
            open.join(", ")
        );
        return Err(MeasurementError::file(path, fault));
    }
    let manifest: Manifest = toml::from_str(text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start.min(text.len()));
        let line = text[..start].matches('\n').count() as u64 + 1;
        MeasurementError::line(path, line, error.message().replace('\n', "; "))
    })?;
    check_extent(path, &manifest)?;
    Ok(manifest)
}

/// Largest number of positions of a set.
const MOST_POSITIONS: usize = 2000;
/// Largest number of FRFs, and of time records, of a set.
const MOST_RECORDS: usize = 5000;
/// Greatest length of a name (characters).
const LONGEST_NAME: usize = 200;

/// Checks that a manifest lists no more than the program handles, under names of bounded length.
fn check_extent(path: &str, manifest: &Manifest) -> Result<(), MeasurementError> {
    let (positions, frfs, motions) = (manifest.position.len(), manifest.frf.len(), manifest.motion.len());
    for (key, count, most) in [
        ("position", positions, MOST_POSITIONS),
        ("frf", frfs, MOST_RECORDS),
        ("motion", motions, MOST_RECORDS),
    ] {
        if count > most {
            return Err(MeasurementError::key(
                path,
                format!("[[{key}]]"),
                format!("appears {count} times; at most {most} are handled"),
            ));
        }
    }
    let records = manifest.frf.iter().flat_map(|frf| [frf.record.as_ref(), Some(&frf.file)]).flatten();
    let motions = manifest.motion.iter().flat_map(|motion| [&motion.name, &motion.file]);
    let names = manifest.position.iter().map(|position| &position.name).chain(records).chain(motions);
    if let Some(name) = names.clone().find(|name| name.contains(['\n', '\r'])) {
        let fault = format!("the name «{}» has a line break; write names in one line", shortened(name, 40));
        return Err(MeasurementError::file(path, fault));
    }
    let mut texts = names.chain([&manifest.title]).map(|name| (name, name.chars().count()));
    match texts.find(|(_, length)| *length > LONGEST_NAME) {
        Some((name, length)) => {
            let name = shortened(name, 20);
            Err(MeasurementError::file(
                path,
                format!("the name «{name}» has {length} characters; at most {LONGEST_NAME} are handled"),
            ))
        }
        None => Ok(()),
    }
}

/// Returns the JSON Schema of a `manifest.toml`, its TOML read as JSON, derived from the types that parse it.
pub fn manifest_schema() -> schemars::Schema {
    schemars::schema_for!(Manifest)
}
