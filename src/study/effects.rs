//! The library of effects.

use crate::stamp::stamp_files;
use crate::{Study, StudyError, StudyResult};
use config::{read_machine, unknown_effect};
use machine::{Data, Effect};
use report::digest;
use report::document::Input;
use report::effects::{EffectEntry, EffectLibraryDocument, EffectParameter};
use report::vocabulary::DataKind;

/// Lists the library of effects, with those of a machine's description where one is named; or the one with an
/// id.
///
/// # Errors  the description cannot be read; no effect has this id.
pub fn effects(config: Option<&str>, id: Option<&str>) -> StudyResult<EffectLibraryDocument> {
    let config = config.map(|path| read_machine(path, &[], &[])).transpose()?;
    let own = config.as_ref().map_or(&[][..], |config| &config.effects);
    let mut effects = config::effect_library()?;
    let library: Vec<String> = effects.iter().map(|effect| effect.id.clone()).collect();
    effects.extend(own.iter().filter(|effect| !library.contains(&effect.id)).cloned());
    if let Some(id) = id {
        if !effects.iter().any(|effect| effect.id == id) {
            return Err(StudyError::input(format!("effects {id}"), unknown_effect(id, &effects)));
        }
        effects.retain(|effect| effect.id == id);
    }
    let input = config
        .iter()
        .map(|config| Input { path: config.path.clone(), sha256: digest(config.text.as_bytes()) });
    Ok(EffectLibraryDocument {
        stamp: stamp_files("effect-library", input.collect(), Vec::new()),
        effects: effects.iter().map(entry).collect(),
    })
}

impl Study {
    /// Checks that effects of these ids exist. `key` names the setting in the message.
    ///
    /// # Errors  one does not; the message names the one that was probably meant.
    pub fn check_effects(&self, key: &str, ids: &[String]) -> StudyResult<()> {
        let effects = &self.config().effects;
        match ids.iter().find(|id| !effects.iter().any(|effect| effect.id == **id)) {
            Some(id) => Err(StudyError::setting(key, "", unknown_effect(id, effects))),
            None => Ok(()),
        }
    }
}

fn entry(effect: &Effect) -> EffectEntry {
    let data = |data: &Data| match data {
        Data::Frf => DataKind::Frf,
        Data::Motion => DataKind::Motion,
    };
    let parameters = effect.patch.parameters.iter().map(|p| {
        let row = EffectParameter {
            unit: p.unit.clone(),
            start: p.start,
            lower: p.lower,
            upper: p.upper,
            source: p.source.clone(),
        };
        (p.id.clone(), row)
    });
    EffectEntry {
        id: effect.id.clone(),
        description: effect.description.clone(),
        signature: effect.signature.clone(),
        discriminating_test: effect.discriminating_test.clone(),
        data: effect.data.iter().map(data).collect(),
        needs: effect.needs.clone(),
        refines: effect.refines.clone(),
        confusable_with: effect.confusable_with.clone(),
        parameters: parameters.collect(),
    }
}
