//! The published bench's measurements, which come with the program.

/// Name of the set that is used when none is given.
pub const BENCH: &str = "measurements/tian";

/// Text of a file of an embedded set.
pub(super) fn embedded_file(set: &str, file: &str) -> Option<&'static str> {
    if set.trim_end_matches('/') != BENCH {
        return None;
    }
    match file {
        "manifest.toml" => Some(include_str!("../../measurements/tian/manifest.toml")),
        "modes.csv" => Some(include_str!("../../measurements/tian/modes.csv")),
        "published.csv" => Some(include_str!("../../measurements/tian/published.csv")),
        _ => None,
    }
}
