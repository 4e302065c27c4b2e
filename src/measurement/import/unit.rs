//! Quantity and SI factor of the units of FRFs.

use numeric::unit::{Dimension, Unit, UnitError, parse, parse_for};

use crate::Quantity;

/// What a unit measures, as far as FRFs need it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Measures {
    /// Displacement, velocity or acceleration, along an axis or about it.
    Motion(Quantity),
    /// Force.
    Force,
    /// Torque.
    Torque,
    /// Motion over force or torque; true for a torque.
    Ratio(Quantity, bool),
    /// Force or torque over motion; true for a torque.
    Inverse(Quantity, bool),
    /// Anything else.
    Other,
}

impl Measures {
    /// Returns its name in a message.
    pub fn name(self) -> String {
        match self {
            Measures::Motion(quantity) => format!("the motion of {}", quantity.word()),
            Measures::Force => "force".into(),
            Measures::Torque => "torque".into(),
            Measures::Ratio(quantity, false) => quantity.word().into(),
            Measures::Ratio(quantity, true) => format!("{} by a torque", quantity.word()),
            Measures::Inverse(quantity, false) => format!("the reciprocal of {}", quantity.word()),
            Measures::Inverse(quantity, true) => format!("the reciprocal of {} by a torque", quantity.word()),
            Measures::Other => "another quantity".into(),
        }
    }
}

fn quantity(time: i32) -> Option<Quantity> {
    match time {
        0 => Some(Quantity::Receptance),
        -1 => Some(Quantity::Mobility),
        -2 => Some(Quantity::Accelerance),
        _ => None,
    }
}

/// Returns what a unit measures.
pub(super) fn measures(unit: Unit) -> Measures {
    let Dimension { length, mass, time, current, temperature } = unit.dimension;
    if current != 0 || temperature != 0 {
        return Measures::Other;
    }
    let is_angular = unit.angle != 0 || unit.turns != 0;
    match (mass, length) {
        _ if unit.dimension == Dimension::FORCE => Measures::Force,
        _ if unit.dimension == Dimension::TORQUE && !is_angular => Measures::Torque,
        (0, 1) => quantity(time).map_or(Measures::Other, Measures::Motion),
        (0, 0) if is_angular => quantity(time).map_or(Measures::Other, Measures::Motion),
        // Force has the time exponent -2.
        (-1, -2..=0) => quantity(time - 2)
            .map_or(Measures::Other, |q| Measures::Ratio(q, length == -2 || (length == -1 && !is_angular))),
        (1, 0..=2) => quantity(-time - 2)
            .map_or(Measures::Other, |q| Measures::Inverse(q, length == 2 || (length == 1 && !is_angular))),
        _ => Measures::Other,
    }
}

/// Parses the unit of a motion, a force or a ratio of them.
pub(super) fn of_frf(label: &str) -> Result<Unit, UnitError> {
    parse_for(label, |unit| measures(unit) != Measures::Other)
}

/// Parses a unit of frequency: factor to Hz.
///
/// # Errors  the unit is unknown, or none of frequency; the text says what it is.
pub(super) fn to_hz(label: &str) -> Result<f64, Fault> {
    let unit = parse(label).map_err(|fault| fault.to_string())?;
    unit.to_hz()
        .ok_or_else(|| format!("the unit «{label}» is that of {}, not of a frequency", unit.dimension.name()))
}

/// What is wrong, without its place.
pub(super) type Fault = String;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_tell_quantity_and_factor() {
        let of = |label: &str| of_frf(label).map(|unit| (measures(unit), unit.to_si()));
        assert_eq!(of("m/s^2"), Ok((Measures::Motion(Quantity::Accelerance), 1.0)));
        assert_eq!(of("mm/s"), Ok((Measures::Motion(Quantity::Mobility), 1e-3)));
        assert_eq!(of("µm"), Ok((Measures::Motion(Quantity::Receptance), 1e-6)));
        assert_eq!(of("g"), Ok((Measures::Motion(Quantity::Accelerance), 9.806_65)));
        assert_eq!(of("kN"), Ok((Measures::Force, 1e3)));
        assert_eq!(of("N*m"), Ok((Measures::Torque, 1.0)));
        assert_eq!(of("(m/s^2)/N"), Ok((Measures::Ratio(Quantity::Accelerance, false), 1.0)));
        assert_eq!(of("g/N"), Ok((Measures::Ratio(Quantity::Accelerance, false), 9.806_65)));
        assert_eq!(of("mm/N"), Ok((Measures::Ratio(Quantity::Receptance, false), 1e-3)));
        assert_eq!(of("(m/s)/N"), Ok((Measures::Ratio(Quantity::Mobility, false), 1.0)));
        assert_eq!(of("rad/(N*m)"), Ok((Measures::Ratio(Quantity::Receptance, true), 1.0)));
        assert_eq!(of("N/mm"), Ok((Measures::Inverse(Quantity::Receptance, false), 1e3)));
        assert_eq!(of("N/(m/s^2)"), Ok((Measures::Inverse(Quantity::Accelerance, false), 1.0)));
        assert_eq!(of("V"), Ok((Measures::Other, 1.0)));
        assert!(of("furlong").unwrap_err().to_string().contains("furlong"));
        assert_eq!(to_hz("kHz"), Ok(1e3));
        assert!(to_hz("s").unwrap_err().contains("a time"));
    }
}
