//! Quantity and SI factor of unit labels.

use crate::Quantity;

/// Parses a response unit: quantity and SI factor.
pub(super) fn response(label: &str) -> Option<(Quantity, f64)> {
    let normalised: String =
        label.trim().to_lowercase().replace(['^', '*', '(', ')', '[', ']', ' '], "").replace('²', "2").replace(['µ', 'μ'], "u");
    let length = |prefix: &str| match prefix {
        "m" => Some(1.0),
        "cm" => Some(1e-2),
        "mm" => Some(1e-3),
        "um" => Some(1e-6),
        "nm" => Some(1e-9),
        "in" => Some(0.0254),
        "ft" => Some(0.3048),
        _ => None,
    };
    if ["g", "gn"].contains(&normalised.as_str()) {
        return Some((Quantity::Accelerance, 9.806_65));
    }
    if let Some(prefix) = normalised.strip_suffix("/s2").or_else(|| normalised.strip_suffix("/s/s")) {
        return length(prefix).map(|l| (Quantity::Accelerance, l));
    }
    if let Some(prefix) = normalised.strip_suffix("/s") {
        return length(prefix).map(|l| (Quantity::Mobility, l));
    }
    length(&normalised).map(|l| (Quantity::Receptance, l))
}

/// Parses a unit of response over force, such as `mm/N` or `(m/s^2)/N`: quantity and SI factor.
pub(super) fn ratio(label: &str) -> Option<(Quantity, f64)> {
    let normalised = label.trim().trim_matches(['(', ')', '[', ']']);
    let (numerator, denominator) = normalised.rsplit_once('/')?;
    let (quantity, factor) = response(numerator)?;
    Some((quantity, factor / force(denominator)?))
}

/// Returns the factor from a frequency unit to Hz.
pub(super) fn frequency(label: &str) -> Option<f64> {
    match label.trim().to_lowercase().as_str() {
        "hz" => Some(1.0),
        "khz" => Some(1e3),
        "rad/s" => Some(1.0 / std::f64::consts::TAU),
        "rpm" | "1/min" => Some(1.0 / 60.0),
        _ => None,
    }
}

/// Returns the factor from a force unit to N.
pub(super) fn force(label: &str) -> Option<f64> {
    match label.trim().to_lowercase().as_str() {
        "n" => Some(1.0),
        "mn" => Some(1e-3),
        "kn" => Some(1e3),
        "lbf" | "lb" => Some(4.448_221_615_260_5),
        "kgf" | "kp" => Some(9.806_65),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_give_quantity_and_factor() {
        assert_eq!(response("m/s^2"), Some((Quantity::Accelerance, 1.0)));
        assert_eq!(response("mm/s"), Some((Quantity::Mobility, 1e-3)));
        assert_eq!(response("µm"), Some((Quantity::Receptance, 1e-6)));
        assert_eq!(response("g"), Some((Quantity::Accelerance, 9.806_65)));
        assert_eq!(response("V"), None);
        assert_eq!(force("kN"), Some(1e3));
        assert_eq!(force("V"), None);
    }
}
