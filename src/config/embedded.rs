//! Embedded configurations: the program runs from any folder.

/// Path of the default configuration.
pub const BENCH: &str = "configs/tian.toml";

/// Returns the text of an embedded configuration by its path in the project.
pub fn embedded_config(path: &str) -> Option<&'static str> {
    match path {
        "configs/tian.toml" => Some(include_str!("../../configs/tian.toml")),
        "configs/tian-as-published.toml" => Some(include_str!("../../configs/tian-as-published.toml")),
        "configs/tian-as-computed.toml" => Some(include_str!("../../configs/tian-as-computed.toml")),
        "configs/twin-ball-screw-as-computed.toml" => {
            Some(include_str!("../../configs/twin-ball-screw-as-computed.toml"))
        }
        "configs/two-inertia.toml" => Some(include_str!("../../configs/two-inertia.toml")),
        "configs/emps.toml" => Some(include_str!("../../configs/emps.toml")),
        "configs/twin-ball-screw.toml" => Some(include_str!("../../configs/twin-ball-screw.toml")),
        "configs/servo-axis.toml" => Some(include_str!("../../configs/servo-axis.toml")),
        "configs/hybrid-axis.toml" => Some(include_str!("../../configs/hybrid-axis.toml")),
        "configs/vertical-axis.toml" => Some(include_str!("../../configs/vertical-axis.toml")),
        _ => None,
    }
}

/// The text of the effect library.
pub(super) const EFFECTS: &str = include_str!("../../configs/effects.toml");
