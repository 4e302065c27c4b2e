//! Digests taken before scoring, and the rejection of later changes.

use std::fs;
use std::path::Path;

use file_access::{MOST_DOCUMENT_BYTES, MOST_TABLE_BYTES, read_file, read_text};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::WithheldError;
use reference_simulator::{Counts, Label};
use report::document::Input;
use report::{digest, to_json};

/// Generator of the cases: the same generator makes the same files.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Generator {
    /// Version of the generating program.
    pub version: String,
    /// Kind of data of the cases: `frf` (hammer tests) or `motion` (time records of a driven axis).
    pub arm: String,
    /// Origin of the data: `independent` (a simulator that shares no code with the models) or `own` (the
    /// models under test).
    pub truth: String,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Cases of each kind in the plan.
    #[schemars(with = "std::collections::BTreeMap<String, usize>")]
    pub counts: Counts,
    /// Layouts of the machines: a name or `all`; machines of the catalogue if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layout: Option<String>,
    /// Number of cases made, from the first of the plan.
    pub cases: usize,
}

/// A sealed case folder.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SealedCase {
    /// Name of its folder in `cases`.
    pub name: String,
    /// Digest of all its files and their names.
    pub sha256: String,
    /// Parameters that the user declares known.
    pub freeze: Vec<String>,
    /// Digest of the same measurements without noise, in `quiet`, for judging closed shares; absent for
    /// hammer tests.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quiet_sha256: Option<String>,
}

/// `seal.json`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seal {
    /// Name and version of the schema.
    pub schema: String,
    /// Generator.
    pub generator: Generator,
    /// Digest of the generator.
    pub generator_sha256: String,
    /// Digest of `labels.json`.
    pub labels_sha256: String,
    /// Digest of the list of cases.
    pub cases_sha256: String,
    /// Case folders.
    pub cases: Vec<SealedCase>,
    /// Cases of the plan that no drawn machine supports, with reasons.
    pub not_made: Vec<String>,
}

const SCHEMA: &str = "jointid/withheld-seal/1";

/// Folder of the cases.
pub const CASES: &str = "cases";
/// Folder of the noise-free measurements of cases; diagnoses do not read it.
pub const QUIET: &str = "quiet";
/// Suffix of the name of a second measurement of a case.
pub const FOLLOW_UP: &str = "-more";

impl Seal {
    /// Seals cases and labels.
    ///
    /// # Errors  a document cannot be written as JSON (a fault of the program).
    pub fn new(
        generator: Generator,
        labels: &str,
        cases: Vec<SealedCase>,
        not_made: Vec<String>,
    ) -> Result<Self, WithheldError> {
        Ok(Self {
            schema: SCHEMA.into(),
            generator_sha256: digest(to_json(&generator)?.as_bytes()),
            labels_sha256: digest(labels.as_bytes()),
            cases_sha256: digest(to_json(&cases)?.as_bytes()),
            generator,
            cases,
            not_made,
        })
    }

    /// Reads the seal of a folder and verifies seal, labels and every case folder.
    ///
    /// # Errors  a file is missing, is of another kind, or was changed; the message names it and what to do.
    pub fn verified(folder: &Path) -> Result<(Self, Vec<Label>), WithheldError> {
        let path = folder.join("seal.json");
        let text = read(&path, "without it the cases cannot be verified")?;
        let seal: Seal = serde_json::from_str(&text)
            .map_err(|e| broken(&path, format!("is not a seal of withheld: {e}")))?;
        let recomputed = Self::new(seal.generator.clone(), "", seal.cases.clone(), Vec::new())?;
        if seal.schema != SCHEMA
            || seal.generator_sha256 != recomputed.generator_sha256
            || seal.cases_sha256 != recomputed.cases_sha256
        {
            return Err(broken(&path, "was changed after sealing, its digests do not match its contents"));
        }
        let path = folder.join("labels.json");
        let text = read(&path, "without it nothing can be scored")?;
        if digest(text.as_bytes()) != seal.labels_sha256 {
            return Err(broken(&path, "its digest is not the sealed one, the labels were changed"));
        }
        let labels: Vec<Label> = serde_json::from_str(&text)
            .map_err(|e| broken(&path, format!("contains no labels of this version: {e}")))?;
        for case in &seal.cases {
            for (whole, sealed) in [(CASES, Some(&case.sha256)), (QUIET, case.quiet_sha256.as_ref())] {
                let (path, Some(sealed)) = (folder.join(whole).join(&case.name), sealed) else { continue };
                if !path.is_dir() {
                    return Err(broken(&path, "the case folder is missing"));
                }
                if folder_digest(&path)? != *sealed {
                    return Err(broken(&path, "its digest is not the sealed one, a file in it was changed"));
                }
            }
            let path = folder.join(CASES).join(&case.name);
            if label_of(&labels, &case.name).is_none() {
                return Err(broken(&path, "has no label in labels.json"));
            }
        }
        Ok((seal, labels))
    }

    /// Returns the lines on cases of the plan that could not be made.
    fn not_made_text(&self) -> String {
        let reasons: Vec<String> = self.not_made.iter().map(|reason| format!("        {reason}\n")).collect();
        if reasons.is_empty() {
            String::new()
        } else {
            format!("{} cases could not be made:\n{}", reasons.len(), reasons.concat())
        }
    }

    /// Returns the text printed before scoring.
    pub fn summary_text(&self) -> String {
        let generator = &self.generator;
        format!(
            "sealed  generator  {}\n        cases      {}\n        labels     {}\n\
             {} folders of {} cases, arm {}, truth {}, {}seed {}; digests of all in seal.json\n{}",
            self.generator_sha256,
            self.cases_sha256,
            self.labels_sha256,
            self.cases.len(),
            generator.cases,
            generator.arm,
            generator.truth,
            generator.layout.as_ref().map_or_else(String::new, |layout| format!("layout {layout}, ")),
            generator.seed,
            self.not_made_text()
        )
    }
}

/// Returns the label of a case folder; for a second measurement that of the first.
pub fn label_of<'a>(labels: &'a [Label], name: &str) -> Option<&'a Label> {
    let first = name.strip_suffix(FOLLOW_UP).unwrap_or(name);
    labels.iter().find(|label| label.case == first)
}

/// Creates the error of a file or folder that is not as it was sealed.
fn broken(path: &Path, fault: impl Into<String>) -> WithheldError {
    WithheldError::Seal { path: path.display().to_string(), fault: fault.into() }
}

fn read(path: &Path, why: &str) -> Result<String, WithheldError> {
    read_text(path, MOST_DOCUMENT_BYTES).map_err(|fault| match fault.is_missing() {
        true => broken(path, format!("is missing, and {why}")),
        false => broken(path, fault.to_string()),
    })
}

/// Returns the files of a folder with their digests, by path inside it.
///
/// # Errors  a file cannot be read.
pub fn files_of(folder: &Path) -> Result<Vec<Input>, WithheldError> {
    fn walk(root: &Path, folder: &Path, found: &mut Vec<Input>) -> std::io::Result<()> {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            if path.is_dir() {
                walk(root, &path, found)?;
            } else {
                let inside = path.strip_prefix(root).unwrap_or(&path);
                let name: Vec<String> =
                    inside.components().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
                found.push(Input {
                    path: name.join("/"),
                    sha256: digest(&read_file(&path, MOST_TABLE_BYTES).map_err(std::io::Error::other)?),
                });
            }
        }
        Ok(())
    }
    let mut found = Vec::new();
    walk(folder, folder, &mut found).map_err(|e| WithheldError::Unreadable {
        path: folder.display().to_string(),
        fault: e.to_string(),
    })?;
    found.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(found)
}

/// Returns the digest of all files of a folder and their names.
///
/// # Errors  a file cannot be read.
pub fn folder_digest(folder: &Path) -> Result<String, WithheldError> {
    let lines: Vec<String> =
        files_of(folder)?.into_iter().map(|file| format!("{}  {}\n", file.sha256, file.path)).collect();
    Ok(digest(lines.concat().as_bytes()))
}
