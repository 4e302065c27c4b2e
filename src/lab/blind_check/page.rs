//! The page of scores of blind checks that are done.

use std::path::PathBuf;

use file_access::{MOST_DOCUMENT_BYTES, read_text};

use crate::withheld::{PageColumn, scores_page};
use study::{StudyError, StudyResult};

/// Formats the scores of one or several blind checks as a page in Markdown, from the `withheld.json` of their
/// folders.
///
/// # Errors  a folder has no `withheld.json` of this version.
pub fn page(folders: &[PathBuf]) -> StudyResult<String> {
    let column = |folder: &PathBuf| -> StudyResult<PageColumn> {
        let path = folder.join("withheld.json");
        let text = read_text(&path, MOST_DOCUMENT_BYTES).map_err(|fault| {
            StudyError::input(path.display(), format!("{fault}; a blind check writes it at its end"))
        })?;
        serde_json::from_str(&text).map_err(|fault| {
            StudyError::input(
                path.display(),
                format!(
                    "holds no scores of this version ({fault}); run the blind check in this folder again"
                ),
            )
        })
    };
    Ok(scores_page(&folders.iter().map(column).collect::<StudyResult<Vec<PageColumn>>>()?))
}
