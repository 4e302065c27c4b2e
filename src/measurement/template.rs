//! Template of a measurement set.

/// Files of the template: name and text. Values that the user must fill in are `nan` or empty cells.
pub const SET_TEMPLATE: [(&str, &str); 2] = [
    ("manifest.toml", include_str!("template/manifest.toml")),
    ("modes.csv", include_str!("template/modes.csv")),
];
