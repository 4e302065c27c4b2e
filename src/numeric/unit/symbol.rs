//! Symbols and names of units as measuring programs write them.

use std::f64::consts::PI;

use super::dimension::{Dimension, Unit};

/// Standard acceleration of free fall (m/s²), 3rd CGPM, 1901.
const FREE_FALL: f64 = 9.806_65;
/// Mass of a pound (kg), international agreement of 1959.
const POUND: f64 = 0.453_592_37;
/// Length of an inch (m), international agreement of 1959.
const INCH: f64 = 0.0254;

/// Meaning of the symbols that stand for two quantities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reading {
    /// «g» is the acceleration of free fall, «lb» a force.
    Vibration,
    /// «g» is the gram, «lb» a mass.
    Mass,
}

const LENGTH: Dimension = Dimension::mechanical(1, 0, 0);
const MASS: Dimension = Dimension::mechanical(0, 1, 0);
const TIME: Dimension = Dimension::mechanical(0, 0, 1);
const ACCELERATION: Dimension = Dimension::mechanical(1, 0, -2);
const PRESSURE: Dimension = Dimension::mechanical(-1, 1, -2);
const NUMBER: Dimension = Dimension::mechanical(0, 0, 0);
const CURRENT: Dimension = Dimension { length: 0, mass: 0, time: 0, current: 1, temperature: 0 };
const TEMPERATURE: Dimension = Dimension { length: 0, mass: 0, time: 0, current: 0, temperature: 1 };
const VOLTAGE: Dimension = Dimension { length: 2, mass: 1, time: -3, current: -1, temperature: 0 };
const RESISTANCE: Dimension = Dimension { length: 2, mass: 1, time: -3, current: -2, temperature: 0 };
const INDUCTANCE: Dimension = Dimension { length: 2, mass: 1, time: -2, current: -2, temperature: 0 };

/// Units that take SI prefixes, by their symbols and their names.
const PREFIXED: [(&str, &str, Unit); 17] = [
    ("m", "metre", Unit::of(1.0, LENGTH)),
    ("m", "meter", Unit::of(1.0, LENGTH)),
    ("N", "newton", Unit::of(1.0, Dimension::FORCE)),
    ("s", "second", Unit::of(1.0, TIME)),
    ("s", "sec", Unit::of(1.0, TIME)),
    ("Hz", "hertz", Unit { factor: 1.0, dimension: Dimension::FREQUENCY, turns: 1, angle: 0 }),
    ("rad", "radian", Unit { factor: 1.0, dimension: NUMBER, turns: 0, angle: 1 }),
    ("Pa", "pascal", Unit::of(1.0, PRESSURE)),
    ("A", "ampere", Unit::of(1.0, CURRENT)),
    ("V", "volt", Unit::of(1.0, VOLTAGE)),
    ("Ohm", "ohm", Unit::of(1.0, RESISTANCE)),
    ("\u{3a9}", "Ohm", Unit::of(1.0, RESISTANCE)),
    ("\u{2126}", "Ohm", Unit::of(1.0, RESISTANCE)),
    ("H", "henry", Unit::of(1.0, INDUCTANCE)),
    ("J", "joule", Unit::of(1.0, Dimension::TORQUE)),
    ("K", "kelvin", Unit::of(1.0, TEMPERATURE)),
    ("gn", "g_n", Unit::of(FREE_FALL, ACCELERATION)),
];

/// SI prefixes: symbol, name, factor.
const PREFIXES: [(&str, &str, f64); 11] = [
    ("p", "pico", 1e-12),
    ("n", "nano", 1e-9),
    ("u", "micro", 1e-6),
    ("m", "milli", 1e-3),
    ("c", "centi", 1e-2),
    ("d", "deci", 1e-1),
    ("k", "kilo", 1e3),
    // No unit here begins with K, so that the common misspelling is unambiguous.
    ("K", "Kilo", 1e3),
    ("M", "mega", 1e6),
    ("G", "giga", 1e9),
    ("T", "tera", 1e12),
];

/// Returns a unit that takes no prefix. The symbols keep their case.
fn whole(symbol: &str, reading: Reading) -> Option<Unit> {
    let pound = |factor| match reading {
        Reading::Vibration => Unit::of(factor * POUND * FREE_FALL, Dimension::FORCE),
        Reading::Mass => Unit::of(factor * POUND, MASS),
    };
    let turns = |factor, dimension| Unit { factor, dimension, turns: 1, angle: 0 };
    Some(match symbol {
        "1" | "-" | "%1" => Unit::ONE,
        "%" => Unit::of(0.01, NUMBER),
        "g" if reading == Reading::Mass => Unit::of(1e-3, MASS),
        "g" | "G" | "Gs" | "gs" | "GS" | "G's" | "g's" | "g0" => Unit::of(FREE_FALL, ACCELERATION),
        // Milli-g of an accelerometer, or a milligram.
        "mg" | "mG" | "ug" | "uG" => {
            let factor = if symbol.starts_with('m') { 1e-3 } else { 1e-6 };
            if reading == Reading::Mass {
                Unit::of(factor * 1e-3, MASS)
            } else {
                Unit::of(factor * FREE_FALL, ACCELERATION)
            }
        }
        "kg" | "Kg" | "KG" => Unit::of(1.0, MASS),
        "Mg" | "t" => Unit::of(1e3, MASS),
        "lbm" => Unit::of(POUND, MASS),
        "lb" | "lbs" | "Lb" | "Lbs" | "LB" | "LBS" => pound(1.0),
        "slug" | "slugs" => Unit::of(POUND * FREE_FALL / (12.0 * INCH), MASS),
        "lbf" | "lbfs" | "Lbf" | "LBF" => Unit::of(POUND * FREE_FALL, Dimension::FORCE),
        "kip" | "kips" | "klbf" => Unit::of(1e3 * POUND * FREE_FALL, Dimension::FORCE),
        "ozf" => Unit::of(POUND * FREE_FALL / 16.0, Dimension::FORCE),
        "pdl" => Unit::of(POUND * 12.0 * INCH, Dimension::FORCE),
        "kgf" | "kp" => Unit::of(FREE_FALL, Dimension::FORCE),
        "gf" => Unit::of(1e-3 * FREE_FALL, Dimension::FORCE),
        "tf" => Unit::of(1e3 * FREE_FALL, Dimension::FORCE),
        "dyn" => Unit::of(1e-5, Dimension::FORCE),
        "in" | "In" | "IN" | "inch" | "inches" | "\"" => Unit::of(INCH, LENGTH),
        "ft" | "Ft" | "FT" | "foot" | "feet" => Unit::of(12.0 * INCH, LENGTH),
        "mil" | "mils" | "thou" => Unit::of(1e-3 * INCH, LENGTH),
        "uin" => Unit::of(1e-6 * INCH, LENGTH),
        "yd" => Unit::of(36.0 * INCH, LENGTH),
        "micron" | "microns" => Unit::of(1e-6, LENGTH),
        "gal" | "Gal" => Unit::of(1e-2, ACCELERATION),
        "min" => Unit::of(60.0, TIME),
        "h" | "hr" => Unit::of(3600.0, TIME),
        "cps" => turns(1.0, Dimension::FREQUENCY),
        "rpm" | "RPM" | "Rpm" | "r/min" | "cpm" | "CPM" => turns(1.0 / 60.0, Dimension::FREQUENCY),
        "rps" => turns(1.0, Dimension::FREQUENCY),
        "hz" | "HZ" => turns(1.0, Dimension::FREQUENCY),
        "khz" | "KHZ" => turns(1e3, Dimension::FREQUENCY),
        "rev" | "turn" | "turns" | "cycle" | "cycles" | "U" => turns(1.0, NUMBER),
        "deg" | "Deg" | "DEG" | "°" | "degree" | "degrees" => {
            Unit { factor: PI / 180.0, dimension: NUMBER, turns: 0, angle: 1 }
        }
        "arcmin" => Unit { factor: PI / 10_800.0, dimension: NUMBER, turns: 0, angle: 1 },
        "arcsec" => Unit { factor: PI / 648_000.0, dimension: NUMBER, turns: 0, angle: 1 },
        "bar" => Unit::of(1e5, PRESSURE),
        "mbar" => Unit::of(1e2, PRESSURE),
        "psi" => Unit::of(POUND * FREE_FALL / (INCH * INCH), PRESSURE),
        "ksi" => Unit::of(1e3 * POUND * FREE_FALL / (INCH * INCH), PRESSURE),
        "°C" | "degC" => Unit::of(1.0, TEMPERATURE),
        "W" => Unit::of(1.0, Dimension::mechanical(2, 1, -3)),
        _ => return None,
    })
}

/// Returns a unit with or without an SI prefix, by symbol (case counts) or by name (case does not count, a
/// plural may).
fn simple(symbol: &str, reading: Reading) -> Option<Unit> {
    if let Some(unit) = whole(symbol, reading) {
        return Some(unit);
    }
    let scaled = |unit: Unit, factor: f64| Unit { factor: unit.factor * factor, ..unit };
    let lowercase = symbol.to_lowercase();
    let singular = lowercase.strip_suffix('s').unwrap_or(&lowercase);
    for (short, name, unit) in PREFIXED {
        if symbol == short || lowercase == name || singular == name {
            return Some(unit);
        }
    }
    for (prefix, prefix_name, factor) in PREFIXES {
        for (short, name, unit) in PREFIXED {
            let is_name = |text: &str| text.strip_prefix(prefix_name).is_some_and(|rest| rest == name);
            if symbol
                .strip_prefix(prefix)
                .is_some_and(|rest| rest == short || (name == "sec" && rest == name))
                || is_name(&lowercase)
                || is_name(singular)
            {
                return Some(scaled(unit, factor));
            }
        }
    }
    match singular {
        "gram" => Some(Unit::of(1e-3, MASS)),
        "kilogram" => Some(Unit::of(1.0, MASS)),
        "minute" => Some(Unit::of(60.0, TIME)),
        _ => None,
    }
}

/// Returns the units of a symbol; two where symbols are joined without a sign, as in «Nm» and «kgcm». An
/// exponent belongs to the last.
pub(super) fn units(symbol: &str, reading: Reading) -> Option<(Unit, Unit)> {
    if let Some(unit) = simple(symbol, reading) {
        return Some((Unit::ONE, unit));
    }
    for head in ["N", "kN", "MN", "mN", "kg", "g", "lbf", "lb"] {
        if let Some(rest) = symbol.strip_prefix(head)
            && ["m", "cm", "mm", "in", "ft", "s"].contains(&rest)
        {
            let reading = if head == "g" { Reading::Mass } else { reading };
            return simple(head, reading).zip(simple(rest, reading));
        }
    }
    None
}
