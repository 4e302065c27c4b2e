//! What can be said on the command line to commands that write pages, beginnings, schemas and manuals.

use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;

/// `report`.
#[derive(Debug, Args)]
pub struct ReportArguments {
    /// Folder with result documents: identification.json, validation.json, comparison.json, peaks.json, diagnosis.json
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// The page; DIR/report.html by default
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// `init`.
#[derive(Debug, Args)]
pub struct InitArguments {
    /// Folder that is to hold machine.toml and measurements/
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// `schema`.
#[derive(Debug, Args)]
pub struct SchemaArguments {
    /// machine, effects, manifest, identification, diagnosis, …
    #[arg(value_name = "NAME", required_unless_present = "list")]
    pub name: Option<String>,
    /// List the names
    #[arg(long, conflicts_with = "name")]
    pub list: bool,
}

/// `completions`.
#[derive(Debug, Args)]
pub struct CompletionsArguments {
    /// Shell
    #[arg(value_enum)]
    pub shell: Shell,
}

/// `man`.
#[derive(Debug, Args)]
pub struct ManArguments {
    /// Folder for jointid.1, jointid-identify.1, …
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}
