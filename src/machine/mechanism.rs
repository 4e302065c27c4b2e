//! The physical meaning of a parameter: which kind of number it is.

/// Physical meaning of a parameter. Translations and rotations share a mechanism; the unit distinguishes
/// them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mechanism {
    /// Stiffness of a joint, of a spring in series or of a contact before it slides.
    Stiffness,
    /// Viscous damping.
    Damping,
    /// Mass or moment of inertia.
    Inertia,
    /// Loss factor.
    LossFactor,
    /// Friction force or torque, or amplitude of a force.
    Force,
    /// Length, diameter, dead zone or amplitude of a displacement.
    Length,
    /// Velocity.
    Velocity,
    /// Period of a wave.
    Period(PeriodAlong),
    /// Delay.
    Delay,
    /// Relative expansion of a lead.
    LeadExpansion,
    /// Another dimensionless number: a factor, a relative change, an exponent, a share or a lever arm between
    /// like motions.
    Ratio,
    /// Another quantity of a known place, with its SI units: a gain, a modulus, a density, a resistance.
    Quantity(&'static [&'static str]),
    /// Any other quantity.
    Other,
}

/// The motion along which a wave is periodic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PeriodAlong {
    /// The travel of the axis (m).
    Travel,
    /// An angle (rad).
    Angle,
    /// The motion of the point that the motor moves: a travel (m) or an angle (rad).
    Motor,
}

impl Mechanism {
    /// Whether the number is dimensionless.
    pub fn is_dimensionless(self) -> bool {
        matches!(self, Mechanism::LossFactor | Mechanism::LeadExpansion | Mechanism::Ratio)
    }

    /// Whether it is the period of a wave.
    pub fn is_period(self) -> bool {
        matches!(self, Mechanism::Period(_))
    }

    /// Returns the SI units that fit; none where any unit does. Of two, the first is that of a translation.
    pub fn units(self) -> &'static [&'static str] {
        match self {
            Mechanism::Stiffness => &["N/m", "N*m/rad"],
            Mechanism::Damping => &["N*s/m", "N*m*s/rad"],
            Mechanism::Inertia => &["kg", "kg*m^2"],
            Mechanism::Force => &["N", "N*m"],
            Mechanism::Length | Mechanism::Period(_) => &["m", "rad"],
            Mechanism::Velocity => &["m/s", "rad/s"],
            Mechanism::Delay => &["s"],
            Mechanism::Ratio | Mechanism::LossFactor | Mechanism::LeadExpansion => &["1"],
            Mechanism::Quantity(units) => units,
            Mechanism::Other => &[],
        }
    }

    /// Returns the mechanism of a parameter whose use does not decide it, by its unit.
    pub(super) fn of_unit(unit: &str) -> Self {
        use Mechanism::{Damping, Delay, Force, Inertia, Length, Other, Ratio, Stiffness, Velocity};
        let by_unit = [Stiffness, Damping, Inertia, Force, Length, Velocity, Delay, Ratio];
        by_unit.into_iter().find(|mechanism| mechanism.units().contains(&unit)).unwrap_or(Other)
    }
}
