//! Arguments that are words of a closed vocabulary.

use std::ffi::OsStr;
use std::sync::LazyLock;

use clap::builder::{PossibleValue, PossibleValuesParser, StringValueParser, TypedValueParser};

/// A word, its value, and its help.
pub type Word<T> = (&'static str, T, &'static str);

/// Returns the parser of an argument that is one of these words.
pub fn one_of<T: Copy + Send + Sync + 'static>(
    words: &'static [Word<T>],
) -> impl TypedValueParser<Value = T> {
    let known = words.iter().map(|(word, _, help)| PossibleValue::new(*word).help(*help));
    PossibleValuesParser::new(known).try_map(move |given| {
        let found = words.iter().find(|(word, ..)| *word == given);
        found.map(|(_, value, _)| *value).ok_or("unknown word")
    })
}

/// Ids of the library of effects.
static EFFECTS: LazyLock<Vec<&'static str>> = LazyLock::new(|| {
    let library = study::effects(None, None).map(|library| library.effects).unwrap_or_default();
    let mut ids: Vec<&'static str> = library.into_iter().map(|effect| &*effect.id.leak()).collect();
    ids.sort_unstable();
    ids.dedup();
    ids
});

/// Parser of ids of effects: it accepts any, since machines may have their own. Shells complete those of the
/// library.
#[derive(Debug, Clone, Copy)]
pub struct EffectId;

impl TypedValueParser for EffectId {
    type Value = String;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<String, clap::Error> {
        StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(EFFECTS.iter().map(|id| PossibleValue::new(*id))))
    }
}
