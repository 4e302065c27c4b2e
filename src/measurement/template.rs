//! Templates of measurement sets.

/// Files of a set of FRFs or modes: name and text. Values that the user must fill in are `nan` or empty cells.
pub const SET_TEMPLATE: [(&str, &str); 2] = [
    ("manifest.toml", include_str!("template/manifest.toml")),
    ("modes.csv", include_str!("template/modes.csv")),
];

/// The manifest of motion records, which the user adds.
pub const MOTION_SET_TEMPLATE: [(&str, &str); 1] = [("manifest.toml", include_str!("template/motion.toml"))];
