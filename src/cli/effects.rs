//! `jointid effects`: the library of effects, or one of them.

use crate::arguments::OutputArguments;
use crate::completion;
use crate::message::shown;
use crate::outcome::{CommandResult, deliver, prepare};
use report::effects::{effect_text, effects_table};

/// `effects`.
#[derive(Debug, clap::Args)]
pub struct EffectsArguments {
    /// Id of an effect, to show it whole
    #[arg(value_name = "ID", add = completion::effects())]
    pub id: Option<String>,
    /// Machine configuration whose own effects are listed, too
    #[arg(long, value_name = "FILE")]
    pub config: Option<String>,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &EffectsArguments) -> CommandResult {
    let document = study::effects(given.config.as_deref(), given.id.as_deref()).map_err(shown)?;
    let text = if given.id.is_some() { effect_text(&document) } else { effects_table(&document) };
    let folder = prepare(&given.output, &["effect-library.json"])?;
    deliver(&given.output, folder.as_ref(), "effect-library.json", &document, &text)
}
