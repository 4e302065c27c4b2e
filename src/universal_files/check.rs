//! Checks of a record header: contradictions and missing units give warnings.

use crate::evidence::AxisName;
use crate::field::is_unused;
use crate::kind::{data_type, function_type};
use crate::place::FilePlace;
use crate::record::{NodeLocation, RecordAxis, RecordHeader};
use crate::warning::{Warning, WarningKind};

/// Warns of an axis in use without unit. A coherence has no unit.
pub(crate) fn unit(
    axis: &RecordAxis,
    name: AxisName,
    place: FilePlace,
    header: &RecordHeader,
    warnings: &mut Vec<Warning>,
) {
    let used = match name {
        AxisName::Abscissa => true,
        AxisName::Ordinate => header.function_type != function_type::COHERENCE,
        AxisName::Denominator | AxisName::Z => axis.data_type != data_type::UNKNOWN,
    };
    if used && axis.unit().is_none() {
        warnings
            .push(WarningKind::BlankUnit { axis: name, units_in_force: header.units.is_some() }.at(place));
    }
}

/// Warns of a direction code that does not exist, and of an entity name that encodes another node or
/// direction.
pub(crate) fn location(location: &NodeLocation, place: FilePlace, warnings: &mut Vec<Warning>) {
    let NodeLocation { entity, node, direction } = location;
    if direction.unsigned_abs() > 6 {
        warnings.push(WarningKind::UnknownDirection { direction: *direction }.at(place));
    }
    if is_unused(entity) {
        return;
    }
    if let Some((named_node, named_direction)) = encoded_location(entity)
        && (named_direction != *direction || named_node.is_some_and(|named| named != *node))
    {
        warnings.push(
            WarningKind::EntityConflict { entity: entity.clone(), node: *node, direction: *direction }
                .at(place),
        );
    }
}

/// Returns node and direction that a name encodes, such as `1+Z`, `12:-X`, `Table:7:+RX`; `None` for other
/// names.
fn encoded_location(entity: &str) -> Option<(Option<i64>, i64)> {
    let (axis_at, axis) = entity.char_indices().next_back()?;
    let translation = match axis.to_ascii_uppercase() {
        'X' => 1,
        'Y' => 2,
        'Z' => 3,
        _ => return None,
    };
    let before = &entity[..axis_at];
    let (before, direction) = match before.strip_suffix(['R', 'r']) {
        Some(before) => (before, translation + 3),
        None => (before, translation),
    };
    let (before, direction) = match before.strip_suffix('-') {
        Some(before) => (before, -direction),
        None => (before.strip_suffix('+')?, direction),
    };
    let point = before.trim_end_matches(':').rsplit(':').next().unwrap_or_default().trim();
    Some((point.parse().ok(), direction))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_encode_node_and_direction() {
        assert_eq!(encoded_location("1+Z"), Some((Some(1), 3)));
        assert_eq!(encoded_location("12:-X"), Some((Some(12), -1)));
        assert_eq!(encoded_location("Table:7:+RY"), Some((Some(7), 5)));
        assert_eq!(encoded_location("P2-X"), Some((None, -1)));
        for name in ["Mic 01", "TestCase", "", "Z", "µ", "axisX"] {
            assert_eq!(encoded_location(name), None, "{name}");
        }
    }
}
