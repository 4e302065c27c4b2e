//! Arguments of `withheld`, the blind check of the diagnosis.

use clap::{Args, ValueEnum};

use crate::blind_check::{Arm, CaseCount, Layouts};
use cli::arguments::OutputArguments;

/// Origins of the cases, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TruthName {
    /// Finite elements and a simulated hammer, independent of the models
    Independent,
    /// The models under test themselves, whose scores are optimistic; for comparison
    Own,
}

/// Reads a number of cases.
fn case_count(text: &str) -> Result<CaseCount, String> {
    match text {
        "quick" => Ok(CaseCount::Quick),
        "full" => Ok(CaseCount::Full),
        _ => match text.parse() {
            Ok(count) if count > 0 => Ok(CaseCount::Count(count)),
            _ => Err("write quick, full or a number of cases from 1".into()),
        },
    }
}

/// Reads the name of a layout, or `all`.
fn layouts(text: &str) -> Result<Layouts, String> {
    let names = |arm| Layouts::names(arm).join(", ");
    Layouts::named(text).ok_or_else(|| {
        format!("write all or one of {}; in motion one of {}", names(Arm::Frf), names(Arm::Motion))
    })
}

/// Kinds of data of the cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ArmName {
    /// Hammer tests
    Frf,
    /// Time records of a driven axis
    Motion,
}

/// Arguments of `withheld`.
#[derive(Debug, Args)]
pub struct WithheldArguments {
    /// Kind of data of the cases; frf by default
    #[arg(long, value_enum)]
    pub arm: Option<ArmName>,
    /// Number of cases: quick (about 120; 80 in motion), full (about 1300; 700 in motion) or a number
    #[arg(long, value_name = "quick|full|N", value_parser = case_count)]
    pub cases: Option<CaseCount>,
    /// Seed of the cases and of every diagnosis; 1 by default
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Layout of the machines: all in turn, or one of short-axis, medium-axis, gantry, fixed-floating,
    /// belt-driven, vertical; in motion one of indirect-encoder, direct-encoder, belt-driven, pid-loop,
    /// feed-forward; machines of the catalogue by default
    #[arg(long, value_name = "all|NAME", value_parser = layouts)]
    pub layout: Option<Layouts>,
    /// Origin of the cases; independent by default
    #[arg(long, value_enum)]
    pub truth: Option<TruthName>,
    /// Make and seal the cases without diagnosing them
    #[arg(long)]
    pub cases_only: bool,
    /// Diagnose only these cases of --out, comma-separated, and keep the answers; runs beside each other
    /// share the cases
    #[arg(long, value_name = "NAMES", value_delimiter = ',', conflicts_with = "cases_only")]
    pub case: Vec<String>,
    /// Print the page of scores (Markdown) of these folders of checks that are done, comma-separated
    #[arg(long, value_name = "FOLDERS", value_delimiter = ',', conflicts_with_all = ["cases", "seed", "arm", "layout", "truth", "cases_only", "case", "ablation", "out", "json"])]
    pub page: Vec<std::path::PathBuf>,
    /// Additional arguments of every diagnosis, as one text
    #[arg(
        long,
        value_name = "ARGUMENTS",
        allow_hyphen_values = true,
        default_value = "",
        hide_default_value = true
    )]
    pub ablation: String,
    /// Keep the facts of each verdict beside its answer, for `jointid lab replay`
    #[arg(long)]
    pub facts: bool,
    /// Number of cases in parallel; all cores by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Time limit (s) after which a diagnosis counts as failed
    #[arg(long, value_name = "S", default_value_t = 1800, value_parser = clap::value_parser!(u32).range(1..))]
    pub time_limit_s: u32,
    #[command(flatten)]
    pub output: OutputArguments,
}
