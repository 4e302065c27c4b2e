//! Messages of errors.

use study::StudyError;

/// Converts an error to its message.
pub fn to_message(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// Returns the message of an error; a setting is shown as its argument, `band` as `--band`.
pub fn shown(error: StudyError) -> String {
    let text = error.to_string();
    match error.setting_key().and_then(|key| Some((key, text.strip_prefix(key)?))) {
        // The argument of a band is in Hz without saying so.
        Some((key, rest)) => {
            format!("--{}{rest}", if key == "band_hz" { "band".into() } else { key.replace('_', "-") })
        }
        None => text,
    }
}
