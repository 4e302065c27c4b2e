//! Quantities of numbers: what a number measures, and which magnitudes of it are plausible.

use super::{Mechanism, PeriodAlong};

/// What a number measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    /// Physical meaning, with its SI units.
    pub mechanism: Mechanism,
    /// Plausible magnitudes; `None` where none is implausible.
    pub magnitude: Option<Magnitude>,
}

/// Magnitudes of a quantity in its SI unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Magnitude {
    /// Unit as it is printed.
    pub unit: &'static str,
    /// Range outside which a number is refused.
    pub possible: [f64; 2],
    /// Range outside which a number is warned about.
    pub plausible: [f64; 2],
    /// Range in which a number has to be in another unit, to name that unit as the likely one.
    pub usual: [f64; 2],
    /// Other units by likelihood, with their factors to the SI unit.
    pub others: &'static [(&'static str, f64)],
}

const fn magnitude(
    unit: &'static str,
    possible: [f64; 2],
    plausible: [f64; 2],
    usual: [f64; 2],
    others: &'static [(&'static str, f64)],
) -> Magnitude {
    Magnitude { unit, possible, plausible, usual, others }
}

/// A quantity without implausible magnitudes.
const fn any(mechanism: Mechanism) -> Quantity {
    Quantity { mechanism, magnitude: None }
}

const fn of(mechanism: Mechanism, magnitude: Magnitude) -> Quantity {
    Quantity { mechanism, magnitude: Some(magnitude) }
}

const PASCAL: &[(&str, f64)] = &[("GPa", 1e9), ("MPa (N/mm²)", 1e6), ("kPa", 1e3)];
const METRE: &[(&str, f64)] = &[("mm", 1e-3), ("µm", 1e-6)];
const SECOND: &[(&str, f64)] = &[("ms", 1e-3), ("µs", 1e-6)];
const NEWTON: &[(&str, f64)] = &[("kN", 1e3), ("mN", 1e-3)];
const KILOGRAM: &[(&str, f64)] = &[("g", 1e-3), ("t", 1e3)];
const PERCENT: &[(&str, f64)] = &[("%", 0.01)];
const SPRING: &[(&str, f64)] = &[("N/µm", 1e6), ("N/mm", 1e3)];
const MODULUS: Mechanism = Mechanism::Quantity(&["Pa"]);
const KG_PER_M3: &[(&str, f64)] = &[("g/cm³", 1e3), ("kg/mm³", 1e9), ("t/mm³", 1e12)];
const KG_M2: &[(&str, f64)] = &[("kg·cm²", 1e-4), ("kg·mm²", 1e-6), ("g·cm²", 1e-7)];
/// Gains and constants of drives: their units differ.
const OF_DRIVE: Magnitude = magnitude("", [1e-15, 1e15], [1e-12, 1e12], [1e-12, 1e12], &[]);

// Quantities of the numbers of a machine.
//
// # Source  materials from polymers to ceramics; screws of 2 mm to 0.5 m, tables of 10 g to 50 t; catalogues of motors and couplings.
pub(super) const YOUNGS_MODULUS: Quantity =
    of(MODULUS, magnitude("Pa", [1.0, 1e15], [1e8, 1.5e12], [4e10, 5e11], PASCAL));
pub(super) const SHEAR_MODULUS: Quantity =
    of(MODULUS, magnitude("Pa", [1.0, 1e15], [3e7, 7e11], [1.5e10, 2.5e11], PASCAL));
pub(super) const PRESSURE: Quantity =
    of(MODULUS, magnitude("Pa", [1.0, 1e15], [1e7, 1e11], [5e8, 1e10], PASCAL));
pub(super) const DENSITY: Quantity = of(
    Mechanism::Quantity(&["kg/m^3"]),
    magnitude("kg/m³", [1e-12, 1e9], [100.0, 3e4], [800.0, 2.3e4], KG_PER_M3),
);
pub(super) const LENGTH: Quantity =
    of(Mechanism::Length, magnitude("m", [1e-9, 1e6], [2e-3, 60.0], [0.02, 30.0], METRE));
pub(super) const DIAMETER: Quantity =
    of(Mechanism::Length, magnitude("m", [1e-9, 1e5], [2e-4, 2.0], [2e-3, 0.6], METRE));
pub(super) const BALL_DIAMETER: Quantity =
    of(Mechanism::Length, magnitude("m", [1e-9, 1e5], [1e-4, 0.2], [3e-4, 0.06], METRE));
pub(super) const LEAD: Quantity =
    of(Mechanism::Length, magnitude("m", [1e-9, 1e5], [5e-5, 0.6], [2e-4, 0.3], METRE));
pub(super) const MASS: Quantity =
    of(Mechanism::Inertia, magnitude("kg", [1e-15, 1e12], [1e-4, 1e5], [0.01, 5e4], KILOGRAM));
pub(super) const INERTIA: Quantity =
    of(Mechanism::Inertia, magnitude("kg·m²", [1e-20, 1e12], [1e-9, 20.0], [1e-8, 10.0], KG_M2));
pub(super) const PERIOD: Quantity =
    of(TIME.mechanism, magnitude("s", [1e-12, 1e6], [1e-7, 1.0], [1e-6, 0.02], SECOND));
pub(super) const LOAD: Quantity =
    of(Mechanism::Force, magnitude("N", [1e-15, 1e15], [1e-4, 1e6], [0.1, 1e5], NEWTON));
pub(super) const LOSS: Quantity =
    of(Mechanism::LossFactor, magnitude("", [1e-15, 100.0], [1e-7, 3.0], [1e-4, 1.0], PERCENT));
pub(super) const PROPORTIONAL_DAMPING: Quantity =
    of(TIME.mechanism, magnitude("s", [1e-15, 1e3], [1e-9, 1.0], [1e-7, 0.1], SECOND));
pub(super) const FRICTION: Quantity =
    of(Mechanism::Force, magnitude("N or N·m", [1e-15, 1e15], [1e-6, 1e6], [1e-3, 1e5], NEWTON));
pub(super) const VELOCITY: Quantity = of(
    Mechanism::Velocity,
    magnitude("m/s or rad/s", [1e-12, 1e6], [1e-7, 100.0], [1e-5, 10.0], &[("mm/s", 1e-3)]),
);
pub(super) const EXPONENT: Quantity =
    of(Mechanism::Ratio, magnitude("", [1e-3, 1e3], [0.1, 10.0], [0.1, 10.0], &[]));
pub(super) const PRESLIDING_STIFFNESS: Quantity =
    of(Mechanism::Stiffness, magnitude("N/m or N·m/rad", [1e-9, 1e18], [0.1, 1e12], [1.0, 1e11], SPRING));
pub(super) const PRESLIDING_DAMPING: Quantity =
    of(Mechanism::Damping, magnitude("N·s/m or N·m·s/rad", [1e-15, 1e15], [1e-9, 1e10], [1e-6, 1e7], &[]));
pub(super) const SHARE: Quantity =
    of(Mechanism::Ratio, magnitude("", [1e-12, 1e6], [1e-6, 5.0], [1e-3, 2.0], PERCENT));
pub(super) const GAP: Quantity =
    of(Mechanism::Length, magnitude("m or rad", [1e-15, 1e3], [1e-8, 0.1], [1e-7, 5e-3], METRE));
pub(super) const EXPANSION: Quantity =
    of(Mechanism::LeadExpansion, magnitude("", [1e-15, 1.0], [1e-9, 0.02], [1e-6, 5e-3], &[("µm/m", 1e-6)]));
pub(super) const TIME: Quantity =
    of(Mechanism::Quantity(&["s"]), magnitude("s", [1e-15, 1e12], [1e-9, 1e4], [1e-6, 10.0], SECOND));
pub(super) const DELAY: Quantity = Quantity { mechanism: Mechanism::Delay, ..TIME };
pub(super) const ENCODER_STEP: Quantity =
    of(Mechanism::Length, magnitude("m or rad", [1e-15, 10.0], [1e-12, 0.01], [1e-10, 1e-3], METRE));
pub(super) const TRAVEL: Quantity =
    of(Mechanism::Length, magnitude("m or rad", [1e-9, 1e9], [1e-6, 1e4], [1e-3, 60.0], METRE));
pub(super) const RESISTANCE: Quantity =
    of(Mechanism::Quantity(&["V/A"]), magnitude("Ω", [1e-9, 1e9], [1e-4, 1e4], [0.01, 1e3], &[("mΩ", 1e-3)]));
pub(super) const INDUCTANCE: Quantity = of(
    Mechanism::Quantity(&["V*s/A"]),
    magnitude("H", [1e-12, 1e6], [1e-7, 10.0], [1e-6, 1.0], &[("mH", 1e-3), ("µH", 1e-6)]),
);
pub(super) const VOLTAGE: Quantity =
    of(Mechanism::Quantity(&["V"]), magnitude("", [1e-12, 1e12], [1e-6, 1e6], [0.1, 1e4], &[]));
/// Output of the velocity loop: a voltage or a current.
pub(super) const OUTPUT: Quantity = Quantity { mechanism: Mechanism::Quantity(&["V", "A"]), ..VOLTAGE };
pub(super) const CURRENT_GAIN: Quantity = of(RESISTANCE.mechanism, OF_DRIVE);
pub(super) const POSITION_GAIN: Quantity = of(RATE.mechanism, OF_DRIVE);
pub(super) const VELOCITY_GAIN: Quantity =
    of(Mechanism::Quantity(&["V*s/m", "A*s/m", "V*s/rad", "A*s/rad"]), OF_DRIVE);
pub(super) const DRIVE_CONSTANT: Quantity =
    of(Mechanism::Quantity(&["N/V", "N*m/V", "N/A", "N*m/A"]), OF_DRIVE);
pub(super) const GRAVITY: Quantity =
    of(Mechanism::Other, magnitude("m/s²", [1e-6, 1e3], [1.0, 30.0], [9.0, 10.0], &[("mm/s²", 1e-3)]));
pub(super) const STIFFNESS: Quantity = any(Mechanism::Stiffness);
pub(super) const DAMPING: Quantity = any(Mechanism::Damping);
pub(super) const FORCE: Quantity = any(Mechanism::Force);
pub(super) const DISPLACEMENT: Quantity = any(Mechanism::Length);
pub(super) const ALONG_TRAVEL: Quantity = any(Mechanism::Period(PeriodAlong::Travel));
pub(super) const ALONG_MOTOR: Quantity = any(Mechanism::Period(PeriodAlong::Motor));
pub(super) const RATIO: Quantity = any(Mechanism::Ratio);
pub(super) const RATE: Quantity = any(Mechanism::Quantity(&["1/s"]));
pub(super) const FEED_FORWARD: Quantity =
    any(Mechanism::Quantity(&["V*s^2/m", "A*s^2/m", "V*s^2/rad", "A*s^2/rad"]));
pub(super) const OTHER: Quantity = any(Mechanism::Other);

/// Magnitudes of parameters, and of stiffness and damping of joints, by their unit.
const BY_UNIT: [(&str, Magnitude); 8] = [
    ("N/m", magnitude("N/m", [1e-12, 1e20], [1e3, 1e12], [1e6, 1e11], SPRING)),
    (
        "N*m/rad",
        magnitude(
            "N·m/rad",
            [1e-15, 1e20],
            [1e-3, 1e10],
            [1.0, 1e8],
            &[("kN·m/rad", 1e3), ("MN·m/rad", 1e6), ("N·mm/rad", 1e-3)],
        ),
    ),
    (
        "N*s/m",
        magnitude("N·s/m", [1e-15, 1e15], [1e-4, 1e10], [1.0, 1e7], &[("N·s/mm", 1e3), ("N·s/µm", 1e6)]),
    ),
    ("N*m*s/rad", magnitude("N·m·s/rad", [1e-20, 1e15], [1e-10, 1e8], [1e-5, 1e3], &[("N·mm·s/rad", 1e-3)])),
    ("kg", magnitude("kg", [1e-15, 1e12], [1e-4, 1e5], [0.01, 5e4], KILOGRAM)),
    (
        "kg*m^2",
        magnitude("kg·m²", [1e-20, 1e12], [1e-10, 20.0], [1e-8, 10.0], &[("kg·cm²", 1e-4), ("kg·mm²", 1e-6)]),
    ),
    ("Pa", magnitude("Pa", [1.0, 1e15], [1e7, 1.5e12], [1e10, 5e11], PASCAL)),
    ("m", magnitude("m", [1e-15, 1e6], [1e-12, 60.0], [1e-6, 30.0], METRE)),
];

impl Magnitude {
    /// Returns the magnitudes of a parameter, or of stiffness and damping of a joint, by its unit.
    pub fn of_unit(unit: &str) -> Option<Magnitude> {
        BY_UNIT.iter().find(|(own, _)| *own == unit).map(|(_, magnitude)| *magnitude)
    }
}
