//! Names of points and directions of universal files.

use universal_files::NodeLocation;

/// Names a direction: `+X` for 1, `-RZ` for −6; empty for 0 and unknown codes.
pub(super) fn direction_name(direction: i64) -> String {
    let axis = match direction.unsigned_abs() {
        1 => "X",
        2 => "Y",
        3 => "Z",
        4 => "RX",
        5 => "RY",
        6 => "RZ",
        _ => return String::new(),
    };
    format!("{}{axis}", if direction < 0 { '-' } else { '+' })
}

/// Formats point, sign and axis, for example `7:+Z`, preceded by the entity's name where it has one.
pub(super) fn point(location: &NodeLocation) -> String {
    let direction = direction_name(location.direction);
    let entity = location.entity.trim();
    let entity = if entity.is_empty() || entity == "NONE" { String::new() } else { format!("{entity}:") };
    if direction.is_empty() {
        format!("{entity}{}", location.node)
    } else {
        format!("{entity}{}:{direction}", location.node)
    }
}
