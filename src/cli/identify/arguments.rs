//! Arguments of `identify`.

use crate::arguments::{OutputArguments, SearchArguments, Sources, SplitArguments};

/// `identify`.
#[derive(Debug, clap::Args)]
pub struct IdentifyArguments {
    #[command(flatten)]
    pub sources: Sources,
    #[command(flatten)]
    pub split: SplitArguments,
    #[command(flatten)]
    pub search: SearchArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}
