//! `jointid effects`: the library of effects, or one of them.

use crate::arguments::OutputArguments;
use crate::outcome::{CommandResult, deliver, prepare, to_message};
use crate::sources::stamp_files;
use config::read_machine;
use machine::{Data, Effect};
use report::digest;
use report::document::Input;
use report::effects::{EffectEntry, EffectLibraryDocument, EffectParameter, effect_text, effects_table};

/// `effects`.
#[derive(Debug, clap::Args)]
pub struct EffectsArguments {
    /// Id of an effect, to show it whole
    #[arg(value_name = "ID")]
    pub id: Option<String>,
    /// Machine configuration whose own effects are listed, too
    #[arg(long, value_name = "FILE")]
    pub config: Option<String>,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &EffectsArguments) -> CommandResult {
    let config = given.config.as_deref().map(|path| read_machine(path, &[], &[])).transpose().map_err(to_message)?;
    let own = config.as_ref().map_or(&[][..], |config| &config.effects);
    let mut effects = config::effect_library().map_err(to_message)?;
    let library: Vec<String> = effects.iter().map(|effect| effect.id.clone()).collect();
    effects.extend(own.iter().filter(|effect| !library.contains(&effect.id)).cloned());
    if let Some(id) = &given.id {
        if !effects.iter().any(|effect| effect.id == *id) {
            let mut known: Vec<&str> = effects.iter().map(|effect| effect.id.as_str()).collect();
            known.dedup();
            return Err(format!("effects {id}: no effect is called «{id}»; there are {}", known.join(", ")));
        }
        effects.retain(|effect| effect.id == *id);
    }
    let input = config.iter().map(|config| Input { path: config.path.clone(), sha256: digest(config.text.as_bytes()) });
    let document = EffectLibraryDocument {
        stamp: stamp_files("effect-library", input.collect(), Vec::new()),
        effects: effects.iter().map(entry).collect(),
    };
    let text = if given.id.is_some() { effect_text(&document) } else { effects_table(&document) };
    let folder = prepare(&given.output)?;
    deliver(&given.output, folder.as_ref(), "effect-library.json", &document, &text)
}

fn entry(effect: &Effect) -> EffectEntry {
    let data = |data: &Data| match data {
        Data::Frf => "frf".to_string(),
        Data::Motion => "motion".to_string(),
    };
    let parameters = effect.patch.parameters.iter().map(|p| {
        let row = EffectParameter { unit: p.unit.clone(), start: p.start, lower: p.lower, upper: p.upper, source: p.source.clone() };
        (p.id.clone(), row)
    });
    EffectEntry {
        id: effect.id.clone(),
        description: effect.description.clone(),
        signature: effect.signature.clone(),
        discriminating_test: effect.discriminating_test.clone(),
        data: effect.data.iter().map(data).collect(),
        needs: effect.needs.clone(),
        confusable_with: effect.confusable_with.clone(),
        parameters: parameters.collect(),
    }
}
