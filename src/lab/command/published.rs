//! `jointid lab published`: published figures of the lumped models, compared with ours.

use crate::document::{published_markdown, published_text};
use crate::published::published;
use cli::arguments::OutputArguments;
use cli::message::shown;
use cli::outcome::{CommandResult, deliver, prepare};

/// Arguments of `published`.
#[derive(Debug, clap::Args)]
pub struct PublishedArguments {
    /// Print the table as Markdown
    #[arg(long)]
    pub markdown: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &PublishedArguments) -> CommandResult {
    let folder = prepare(&given.output, &["published.json"])?;
    let document = published().map_err(shown)?;
    let text = if given.markdown { published_markdown(&document) } else { published_text(&document) };
    deliver(&given.output, folder.as_ref(), "published.json", &document, &text)
}
