//! Published figures of the lumped models, compared with ours.

mod figure;
mod servo;
mod twin;
mod vertical;

use self::figure::CONFIGS;
use crate::StudyResult;
use crate::stamp::stamp_files;
use config::embedded_config;
use report::digest;
use report::document::{Input, Stamp};
use report::simulation::PublishedDocument;

/// Computes the published figures of the lumped models, from machines that are built in, and compares them with the printed ones.
///
/// # Errors  a built-in machine does not allow a computation.
pub fn published() -> StudyResult<PublishedDocument> {
    let mut figures = twin::figures()?;
    figures.extend(servo::figures()?);
    figures.extend(vertical::figures()?);
    let input = |path: &&str| embedded_config(path).map(|text| Input { path: (*path).into(), sha256: digest(text.as_bytes()) });
    let stamp = Stamp { seed: 1, ..stamp_files("published", CONFIGS.iter().filter_map(input).collect(), Vec::new()) };
    Ok(PublishedDocument { stamp, figures })
}
