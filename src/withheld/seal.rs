//! Digests taken before scoring, and the refusal of what changed since.

use std::fs;
use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use reference_simulator::{Counts, Label};
use report::document::Input;
use report::{digest, to_json};

/// What makes the cases: the same generator makes the same files again.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Generator {
    /// Version of the program that made them.
    pub version: String,
    /// What the cases are data of: `frf` (hammer tests) or `motion` (time records of a driven axis).
    pub arm: String,
    /// `independent` (a truth that shares nothing with the models) or `own` (the models under test).
    pub truth: String,
    /// Seed.
    pub seed: u64,
    /// Cases of each kind in the plan.
    #[schemars(with = "std::collections::BTreeMap<String, usize>")]
    pub counts: Counts,
    /// Cases made, from the first of the plan on.
    pub cases: usize,
}

/// One sealed case folder.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SealedCase {
    /// Name of its folder in `cases`.
    pub name: String,
    /// Digest of all its files and their names.
    pub sha256: String,
    /// Parameters that its user declares known.
    pub freeze: Vec<String>,
    /// Digest of the same measurements without noise, in `quiet`, by which shares closed are judged; absent in hammer tests.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quiet_sha256: Option<String>,
}

/// `seal.json`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seal {
    /// Name and version of the document's form.
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
    /// Cases of the plan that no machine drawn could carry, and why.
    pub not_made: Vec<String>,
}

const SCHEMA: &str = "jointid/withheld-seal/1";
const MEND: &str = "name a new folder with --out and the cases are made anew";

/// Folder of the cases.
pub const CASES: &str = "cases";
/// Folder of what cases would read without noise; no diagnosis is told of it.
pub const QUIET: &str = "quiet";
/// End of the name of a second measurement of a case.
pub const FOLLOW_UP: &str = "-more";

impl Seal {
    /// Seals cases and labels.
    ///
    /// # Errors  a document cannot be written as JSON (a fault of the program).
    pub fn new(generator: Generator, labels: &str, cases: Vec<SealedCase>, not_made: Vec<String>) -> Result<Self, String> {
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

    /// Reads the seal of a folder and checks that seal, labels and every case folder are as they were sealed.
    ///
    /// # Errors  a file is missing, is none of this kind, or was changed: named, with the mend.
    pub fn verified(folder: &Path) -> Result<(Self, Vec<Label>), String> {
        let path = folder.join("seal.json");
        let text = read(&path, "without it nobody can tell whether the cases are those that were made")?;
        let seal: Seal = serde_json::from_str(&text).map_err(|e| format!("{}: is no seal of withheld: {e}; {MEND}", path.display()))?;
        let again = Self::new(seal.generator.clone(), "", seal.cases.clone(), Vec::new())?;
        if seal.schema != SCHEMA || seal.generator_sha256 != again.generator_sha256 || seal.cases_sha256 != again.cases_sha256 {
            return Err(format!("{}: was changed after it was written, its own digests differ; {MEND}", path.display()));
        }
        let path = folder.join("labels.json");
        let text = read(&path, "without it nothing can be scored")?;
        if digest(text.as_bytes()) != seal.labels_sha256 {
            return Err(format!("{}: its digest is not the sealed one, the labels were changed; {MEND}", path.display()));
        }
        let labels: Vec<Label> =
            serde_json::from_str(&text).map_err(|e| format!("{}: holds no labels of this version: {e}; {MEND}", path.display()))?;
        for case in &seal.cases {
            for (whole, sealed) in [(CASES, Some(&case.sha256)), (QUIET, case.quiet_sha256.as_ref())] {
                let (path, Some(sealed)) = (folder.join(whole).join(&case.name), sealed) else { continue };
                if !path.is_dir() {
                    return Err(format!("{}: the case folder is missing; {MEND}", path.display()));
                }
                if folder_digest(&path)? != *sealed {
                    return Err(format!("{}: its digest is not the sealed one, a file in it was changed; {MEND}", path.display()));
                }
            }
            let path = folder.join(CASES).join(&case.name);
            if label_of(&labels, &case.name).is_none() {
                return Err(format!("{}: has no label in labels.json; {MEND}", path.display()));
            }
        }
        Ok((seal, labels))
    }

    /// What is printed before anything is scored.
    pub fn summary_text(&self) -> String {
        let generator = &self.generator;
        format!(
            "sealed  generator  {}\n        cases      {}\n        labels     {}\n\
             {} folders of {} cases, arm {}, truth {}, seed {}; digests of all in seal.json\n",
            self.generator_sha256,
            self.cases_sha256,
            self.labels_sha256,
            self.cases.len(),
            generator.cases,
            generator.arm,
            generator.truth,
            generator.seed
        )
    }
}

/// The label of a case folder; that of its first measurement for a second one.
pub fn label_of<'a>(labels: &'a [Label], name: &str) -> Option<&'a Label> {
    let first = name.strip_suffix(FOLLOW_UP).unwrap_or(name);
    labels.iter().find(|label| label.case == first)
}

fn read(path: &Path, why: &str) -> Result<String, String> {
    fs::read_to_string(path).map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => format!("{}: is missing, and {why}; {MEND}", path.display()),
        _ => format!("{}: {e}; {MEND}", path.display()),
    })
}

/// Files of a folder with their digests, by path inside it.
///
/// # Errors  a file cannot be read.
pub fn files_of(folder: &Path) -> Result<Vec<Input>, String> {
    fn walk(root: &Path, folder: &Path, found: &mut Vec<Input>) -> std::io::Result<()> {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            if path.is_dir() {
                walk(root, &path, found)?;
            } else {
                let inside = path.strip_prefix(root).unwrap_or(&path);
                let name: Vec<String> = inside.components().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
                found.push(Input { path: name.join("/"), sha256: digest(&fs::read(&path)?) });
            }
        }
        Ok(())
    }
    let mut found = Vec::new();
    walk(folder, folder, &mut found).map_err(|e| format!("{}: {e}", folder.display()))?;
    found.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(found)
}

/// Digest of all files of a folder and their names.
///
/// # Errors  a file cannot be read.
pub fn folder_digest(folder: &Path) -> Result<String, String> {
    let lines: Vec<String> = files_of(folder)?.into_iter().map(|file| format!("{}  {}\n", file.sha256, file.path)).collect();
    Ok(digest(lines.concat().as_bytes()))
}
