//! Figures of the five papers, compared with ours.

mod figure;
mod hybrid;
mod servo;
mod tian;
mod twin;
mod twin_position;
mod vertical;

use crate::document::published::{PublishedDocument, count};
use config::embedded_config;
use report::digest;
use report::document::{Input, Stamp};
use study::StudyResult;
use study::stamp_files;

/// The configurations that the figures are computed from.
const CONFIGS: [&str; 7] = [
    tian::CONFIG_AS_PUBLISHED,
    tian::CONFIG_AS_COMPUTED,
    tian::CONFIG_HELD,
    twin_position::CONFIG,
    twin_position::CONFIG_AS_COMPUTED,
    servo::CONFIG,
    vertical::CONFIG,
];

/// Computes the figures of the five papers from machines that are built in, as printed and with the cause of
/// a difference mended, and compares them with the printed ones.
///
/// # Errors  a built-in machine does not allow a computation.
pub fn published() -> StudyResult<PublishedDocument> {
    let mut figures = tian::figures()?;
    figures.extend(twin::figures()?);
    figures.extend(servo::figures()?);
    figures.extend(hybrid::figures()?);
    figures.extend(vertical::figures()?);
    let input = |path: &&str| {
        embedded_config(path).map(|text| Input { path: (*path).into(), sha256: digest(text.as_bytes()) })
    };
    let stamp =
        Stamp { seed: 1, ..stamp_files("published", CONFIGS.iter().filter_map(input).collect(), Vec::new()) };
    let count = count(&figures);
    Ok(PublishedDocument { stamp, figures, count })
}
