//! Arguments that are words of a closed vocabulary.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

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
