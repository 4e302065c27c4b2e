//! Documents written to a temporary name and renamed, so that none is ever half there.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::Serialize;
use sha2::{Digest, Sha256};

/// SHA-256 of bytes, in hexadecimal.
pub fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// A document as JSON text with a line end.
///
/// A number that is not finite becomes null.
///
/// # Errors  a map's key is no text (a fault of the program).
pub fn to_json<T: Serialize>(document: &T) -> Result<String, String> {
    serde_json::to_string_pretty(document).map(|text| text + "\n").map_err(|e| format!("cannot write the document as JSON: {e}"))
}

/// A folder that results go to.
#[derive(Debug, Clone)]
pub struct OutputFolder {
    path: PathBuf,
}

impl OutputFolder {
    /// Makes sure that the folder can be made, or files written into it; makes nothing yet.
    ///
    /// # Errors  the name is that of a file, or writing is not permitted.
    pub fn prepare(path: &Path) -> Result<Self, String> {
        let told = |e: std::io::Error| {
            let fault = match e.kind() {
                std::io::ErrorKind::PermissionDenied => "writing there is not permitted; name another folder with --out".to_string(),
                std::io::ErrorKind::AlreadyExists | std::io::ErrorKind::NotADirectory => "is a file; name a folder with --out".into(),
                _ => e.to_string(),
            };
            format!("{}: {fault}", path.display())
        };
        if path.is_file() {
            return Err(format!("{}: is a file; name a folder with --out", path.display()));
        }
        // Nothing is made before there is something to write: the nearest folder that exists must take a file.
        let near = path.ancestors().find(|p| p.exists()).filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if near.is_file() {
            return Err(format!("{}: is a file; name a folder with --out", near.display()));
        }
        let probe = near.join(format!(".jointid-{}", std::process::id()));
        fs::write(&probe, b"").and_then(|()| fs::remove_file(&probe)).map_err(told)?;
        Ok(OutputFolder { path: path.into() })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file whole: to a temporary name, then renamed.
    ///
    /// # Errors  the disk is full, or writing is not permitted.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<PathBuf, String> {
        let target = self.path.join(name);
        let file = target.file_name().map_or_else(|| "result".into(), |f| f.to_string_lossy().into_owned());
        let temporary = target.with_file_name(format!(".{file}.{}", std::process::id()));
        let made = fs::create_dir_all(target.parent().unwrap_or(&self.path));
        let written = made
            .and_then(|()| fs::File::create(&temporary))
            .and_then(|mut file| file.write_all(content).and_then(|()| file.sync_all()))
            .and_then(|()| fs::rename(&temporary, &target));
        if let Err(error) = written {
            let _ = fs::remove_file(&temporary);
            return Err(format!("{}: cannot be written: {error}", target.display()));
        }
        Ok(target)
    }
}
