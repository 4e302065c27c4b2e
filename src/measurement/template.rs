//! The beginning of a measurement set, to be filled in.

/// Files of an empty set: name and text. What the user must say is `nan` there, or an empty cell.
pub const SET_TEMPLATE: [(&str, &str); 2] =
    [("manifest.toml", include_str!("template/manifest.toml")), ("modes.csv", include_str!("template/modes.csv"))];
