//! Identification: parameters from FRFs, modes or motion records.

mod records;
mod responses;

use crate::{Study, StudyResult};
use report::digest_of;
use report::document::IdentificationDocument;

impl Study {
    /// Identifies the machine's free parameters from the fitted data, and predicts the held-out data. Where
    /// nothing is held out, each position is predicted by a fit without it.
    ///
    /// # Errors  a setting is outside its range; machine and set do not fit together; the data do not
    ///   suffice.
    pub fn identify(&self) -> StudyResult<IdentificationDocument> {
        self.check_observations()?;
        let of_motion = self.is_on_motion();
        let mut document =
            if of_motion { self.identify_from_records() } else { self.identify_from_responses() }?;
        document.content_sha256 = Some(digest_of(&document)?);
        Ok(document)
    }
}

#[cfg(test)]
mod tests;
