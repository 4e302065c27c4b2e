//! Published measurement sets embedded in the program.

/// Name of the default set.
pub const BENCH: &str = "measurements/tian";

/// Name of the set of the twin ball screw.
const TWIN: &str = "measurements/twin-ball-screw";

/// Returns the text of a file of an embedded set.
pub(super) fn embedded_file(set: &str, file: &str) -> Option<&'static str> {
    match (set.trim_end_matches('/'), file) {
        (BENCH, "manifest.toml") => Some(include_str!("../../measurements/tian/manifest.toml")),
        (BENCH, "modes.csv") => Some(include_str!("../../measurements/tian/modes.csv")),
        (BENCH, "published.csv") => Some(include_str!("../../measurements/tian/published.csv")),
        (TWIN, "manifest.toml") => Some(include_str!("../../measurements/twin-ball-screw/manifest.toml")),
        (TWIN, "modes.csv") => Some(include_str!("../../measurements/twin-ball-screw/modes.csv")),
        (TWIN, "published.csv") => Some(include_str!("../../measurements/twin-ball-screw/published.csv")),
        _ => None,
    }
}
